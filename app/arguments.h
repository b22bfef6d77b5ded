// Words of the command line into values. Everything throws InputError naming the option.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calot/compliance/compliance.h"
#include "calot/cut/cut.h"

namespace CLI {
class App;
}

namespace calot {

/// "px,py,pz,nx,ny,nz": a point in metres or with units, and a normal.
Plane parse_plane(const std::string& text);
/// "cx,cy,cz,nx,ny,nz,ax,ay,az,length,width": centre, normal, direction of the length, full length and width.
BladePatch parse_blade(const std::string& text);
/// "V,fx,fy,fz": a vertex number and newtons.
PointForce parse_force(const std::string& text);

/// The options that say what to cut, shared by the commands that cut.
struct CutArguments {
  std::vector<std::string> planes, patches;
  std::string region = "*";
  bool clean = false;

  void add_to(CLI::App& command);
  [[nodiscard]] std::vector<Blade> blades() const;             ///< planes, then patches
  [[nodiscard]] std::string name_of(std::size_t blade) const;  ///< as it was given: "--plane 10mm,0,0,1,0,0"
  [[nodiscard]] CutOptions options() const { return {.region = region, .clean = clean}; }
};

/// An option given as often as wanted, each time with one value.
void add_repeated(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                  const std::string& description, bool required);

/// The ending of a file name in lower case, with its dot.
std::string ending_of(const std::filesystem::path& path);
/// Throws InputError unless the file's folder exists and the name is no folder, so that long work isn't done in vain.
void check_output_file(const std::filesystem::path& path);
/// Makes a folder for what a command writes. Throws InputError for one that holds something, FailedError if it can't.
void make_output_folder(const std::filesystem::path& folder);
/// Throws InputError for a vertex that the mesh doesn't have.
void check_forces(const std::vector<PointForce>& forces, const Model& model);
/// Warns of forces on fixed vertices.
void warn_about_idle(const std::vector<PointForce>& forces, const Model& model);

}  // namespace calot
