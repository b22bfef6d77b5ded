// One thing broken at a time: the finding must be the expected one, and the only one.
#include <gtest/gtest.h>

#include "calot/base/files.h"
#include "calot/mesh/mesh_file.h"
#include "tests/patient/small_patient.h"
#include "tests/support/files.h"

namespace {

using namespace calot;
using namespace calot::test;
namespace fs = std::filesystem;

std::string describe(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& f : findings)
    text += (f.error ? "error: " : "warning: ") + f.where + ": " + f.what + "; " + f.what_to_do + "\n";
  return text;
}

void expect_only(const fs::path& folder, bool error, const std::string& text) {
  const std::vector<Finding> findings = check_patient(folder);
  const std::string all = describe(findings);
  EXPECT_EQ(findings.size(), 1U) << "wanted: " << text << "\n" << all;
  EXPECT_NE(all.find(text), std::string::npos) << "wanted: " << text << "\n" << all;
  if (findings.size() != 1) return;
  EXPECT_EQ(findings[0].error, error) << all;
  EXPECT_FALSE(findings[0].where.empty() || findings[0].what.empty() || findings[0].what_to_do.empty()) << all;
  EXPECT_EQ(all.find(folder.string()), std::string::npos) << all;
}

/// Breaks the patient before it is written.
template <class Break>
void expect_finding(bool error, const std::string& text, const Break& harm) {
  SCOPED_TRACE(text);
  TempFolder folder;
  Patient patient = small_patient();
  harm(patient);
  write_small_patient(folder.path(), patient);
  expect_only(folder.path(), error, text);
}

/// Breaks the text of patient.toml, or another file of the folder.
void expect_finding_in_text(bool error, const std::string& text, const std::string& from, const std::string& to,
                            const std::string& file = "patient.toml") {
  SCOPED_TRACE(text);
  TempFolder folder;
  write_small_patient(folder.path());
  std::string bytes = read_bytes(folder / file);
  const std::size_t place = bytes.find(from);
  ASSERT_NE(place, std::string::npos) << from;
  write_bytes(folder / file, bytes.replace(place, from.size(), to));
  expect_only(folder.path(), error, text);
}

Port& port_named(Patient& patient, const std::string& name) {
  for (Port& port : patient.landmarks.ports)
    if (port.name == name) return port;
  throw std::logic_error(name);
}

Attachment& attachment(Patient& patient, std::size_t number) {
  return patient.attachments.at(number);
}

TubeSite& clip(Patient& patient, std::size_t number) {
  return patient.landmarks.clips.at(number);
}

/// The middle line from the far side.
Centreline duct_line() {
  Centreline line = small_patient().lines[0];
  std::reverse(line.points.begin(), line.points.end());
  std::reverse(line.radii.begin(), line.radii.end());
  return line;
}

TEST(PatientCheck, NothingIsWrongWithASoundPatient) {
  TempFolder folder;
  write_small_patient(folder.path());
  EXPECT_EQ(describe(check_patient(folder.path())), "");
  EXPECT_NE(message_of([&] { check_patient(folder / "elsewhere"); }).find("there is no such folder"),
            std::string::npos);
}

// ---- files ----

TEST(PatientCheck, MissingFiles) {
  TempFolder folder;
  write_small_patient(folder.path());
  for (const std::string& name : patient_files(small_patient())) {
    SCOPED_TRACE(name);
    fs::rename(folder / name, folder / "aside");
    expect_only(folder.path(), true, name);
    fs::rename(folder / "aside", folder / name);
  }
}

TEST(PatientCheck, ChangedFiles) {
  const std::map<std::string, std::pair<bool, std::string>> expected{
      {"mesh.msh", {true, "attachments and landmarks no longer fit"}},
      {"mesh.vtu", {false, "was changed after the folder was made"}},
      {"surfaces/liver.ply", {true, "no longer fits the mesh"}},
      {"labels.nii.gz", {true, "no longer fits the mesh"}},
      {"centrelines.mrk.json", {false, "was changed after"}},
      {"quality.json", {false, "was changed after"}},
      {"provenance.json", {true, "provenance.json"}}};
  TempFolder folder;
  write_small_patient(folder.path());
  for (const auto& [name, finding] : expected) {
    SCOPED_TRACE(name);
    const std::string whole = read_bytes(folder / name);
    // A blank at the end changes nothing but the bytes; half a provenance can't be read.
    write_bytes(folder / name, name == "provenance.json" ? whole.substr(0, whole.size() / 2) : whole + " ");
    expect_only(folder.path(), finding.first, finding.second);
    write_bytes(folder / name, whole);
  }
}

TEST(PatientCheck, AnotherMeshOrQualityThanTheFolders) {
  TempFolder folder, other;
  write_small_patient(folder.path());
  write_mesh(folder / "other.msh", read_mesh(folder / "mesh.msh").mesh);
  std::string text = read_bytes(folder / "patient.toml");
  text.replace(text.find("mesh = \"mesh.msh\""), 17, "mesh = \"other.msh\"");
  write_bytes(folder / "patient.toml", text);
  expect_only(folder.path(), true, "other.msh: has no hash in provenance.json");
  // A quality.json that fits its hash but not the mesh.
  LabelMesh meshed = small_label_mesh(small_patient());
  meshed.quality.tets += 1;
  const Patient patient = small_patient();
  write_patient(other.path(), patient, meshed, small_anatomy(patient), small_provenance());
  expect_only(other.path(), true, "quality.json: describes another mesh");
}

TEST(PatientCheck, ProvenanceCantLeadOutOfTheFolder) {
  expect_finding_in_text(true, "\"../mesh.vtu\" is not a file of this folder",
                         "\"mesh.vtu\":", "\"../mesh.vtu\":", "provenance.json");
}

TEST(PatientCheck, TextOfFilesDoesNothingToTheTerminal) {
  TempFolder folder;
  write_small_patient(folder.path());
  const auto expect_plain = [&](const std::string& file, const std::string& from, const std::string& to,
                                const std::string& text) {
    const std::string whole = read_bytes(folder / file);
    std::string bytes = whole;
    ASSERT_NE(bytes.find(from), std::string::npos) << from;
    write_bytes(folder / file, bytes.replace(bytes.find(from), from.size(), to));
    expect_only(folder.path(), true, text);
    for (const Finding& f : check_patient(folder.path()))
      for (const char c : f.where + f.what + f.what_to_do) EXPECT_GE(static_cast<unsigned char>(c), 0x20) << text;
    write_bytes(folder / file, whole);
  };
  const std::string key = "\"mesh.vtu\":";
  expect_plain("provenance.json", key, "\"a\\nerror: b\\u001b[31m\":", "a?error: b?[31m: the file is missing");
  expect_plain("provenance.json", key, "\"../a\\nb\\u001b[31m\":", "\"../a?b?[31m\" is not a file of this folder");
  expect_plain("provenance.json", key, "\"mesh.vtu\\u0000\":", "is not a file of this folder");
  expect_plain("provenance.json", key, "\"\":", "\"\" is not a file of this folder");
  expect_plain("provenance.json", key, "\"" + std::string(5000, 'x') + "\":", std::string(60, 'x') + "…: ");
  expect_plain("patient.toml", "mesh = \"mesh.msh\"", "mesh = \"a\\nb\\u001b.msh\"",
               "mesh = \"a?b?.msh\" is not a file of this folder");
}

/// Takes the line of a key out of [files].
void forget(const fs::path& folder, const std::string& key) {
  std::string text = read_bytes(folder / "patient.toml");
  const std::size_t place = text.find("\n" + key + " = \"");
  ASSERT_NE(place, std::string::npos) << key;
  write_bytes(folder / "patient.toml", text.erase(place, text.find('\n', place + 1) - place));
}

/// Exchanges a file's bytes together with its hash.
void exchange(const fs::path& folder, const std::string& name, const std::string& bytes) {
  const std::string before = sha256_of_file(folder / name);
  write_bytes(folder / name, bytes);
  std::string text = read_bytes(folder / "provenance.json");
  const std::size_t place = text.find("\"" + name + "\": \"" + before);
  ASSERT_NE(place, std::string::npos) << name;
  write_bytes(folder / "provenance.json",
              text.replace(text.find(before, place), before.size(), sha256_of_file(folder / name)));
}

TEST(PatientCheck, EveryFileMustBeNamed) {
  for (const std::string key : {"labels", "quality", "provenance", "model"}) {
    SCOPED_TRACE(key);
    TempFolder folder;
    write_small_patient(folder.path());
    forget(folder.path(), key);
    expect_only(folder.path(), true, "patient.toml, files: \"" + key + "\" is missing");
  }
  TempFolder folder;
  write_small_patient(folder.path());
  forget(folder.path(), "centrelines");
  EXPECT_NE(describe(check_patient(folder.path())).find("error: patient.toml, files: \"centrelines\" is missing"),
            std::string::npos);
  forget(folder.path(), "mesh");
  EXPECT_NE(describe(check_patient(folder.path())).find("\"mesh\" is missing"), std::string::npos);
}

TEST(PatientCheck, JunkIsNotedWithoutAnyHash) {
  TempFolder folder;
  write_small_patient(folder.path());
  for (const std::string key : {"labels", "quality", "provenance", "model"}) forget(folder.path(), key);
  write_bytes(folder / "surfaces/liver.ply", "junk");
  const std::vector<Finding> findings = check_patient(folder.path());
  EXPECT_EQ(findings.size(), 5U) << describe(findings);
  EXPECT_NE(describe(findings).find("error: surfaces/liver.ply"), std::string::npos) << describe(findings);
}

TEST(PatientCheck, EveryNamedFileMustHaveAHash) {
  TempFolder folder;
  write_small_patient(folder.path());
  write_bytes(folder / "provenance.json", "{\"files\":{}}");
  const std::size_t surfaces = small_patient().materials.size();
  std::string all = describe(check_patient(folder.path()));
  EXPECT_EQ(check_patient(folder.path()).size(), 4 + surfaces) << all;
  for (const char* name : {"mesh.msh", "centrelines.mrk.json", "labels.nii.gz", "quality.json", "surfaces/liver.ply"})
    EXPECT_NE(all.find("error: " + std::string(name) + ": has no hash in provenance.json"), std::string::npos) << all;
  const std::string liver = read_bytes(folder / "surfaces/liver.ply");
  write_bytes(folder / "surfaces/liver.ply", liver.substr(0, 1000));
  all = describe(check_patient(folder.path()));
  EXPECT_EQ(check_patient(folder.path()).size(), 5 + surfaces) << all;
}

TEST(PatientCheck, SurfacesAreOpened) {
  const auto expect_for = [](const std::string& text, const auto& change) {
    TempFolder folder;
    write_small_patient(folder.path());
    exchange(folder.path(), "surfaces/liver.ply", change(folder.path()));
    expect_only(folder.path(), true, text);
  };
  expect_for("surfaces/liver.ply: is not the surface of the liver: a vertex lies 10 mm away",
             [](const fs::path& folder) { return read_bytes(folder / "surfaces/gallbladder.ply"); });
  expect_for("surfaces/liver.ply",
             [](const fs::path& folder) { return read_bytes(folder / "surfaces/liver.ply").substr(0, 1000); });
  expect_for("surfaces/liver.ply", [](const fs::path&) {
    return std::string(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\nproperty double "
        "z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n40 -50 130\n");
  });
}

/// A folder whose quality.json says something else of a region.
template <class Change>
void write_with_region(const fs::path& folder, Structure s, const Change& change) {
  const Patient patient = small_patient();
  LabelMesh meshed = small_label_mesh(patient);
  for (MeshedRegion& region : meshed.regions)
    if (region.label == label_of(s)) change(region);
  write_patient(folder, patient, meshed, small_anatomy(patient), small_provenance());
}

TEST(PatientCheck, VolumesThatTheMeshLost) {
  const auto expect_for = [](Structure s, bool error, const std::string& text, const auto& change) {
    TempFolder folder;
    write_with_region(folder.path(), s, change);
    expect_only(folder.path(), error, text);
  };
  // The duct is four cubes of 125 mm3.
  expect_for(
      Structure::cystic_duct, false,
      "quality.json: the cystic duct has 9.1 % less volume in the mesh than in the voxels (0.5 against 0.55 mL); "
      "make it again with more --tets",
      [](MeshedRegion& region) { region.voxel_volume = 0.55e-6; });
  expect_for(Structure::liver, false, "the liver has 25 % more volume in the mesh",
             [](MeshedRegion& region) { region.voxel_volume *= 0.8; });
  expect_for(Structure::liver, true, "has no voxel_volume_ml of the liver",
             [](MeshedRegion& region) { region.voxel_volume = 0; });
  expect_for(Structure::liver, true, "quality.json: describes another mesh",
             [](MeshedRegion& region) { region.quality.volume *= 1.01; });
  expect_for(Structure::liver, true, "quality.json: describes another mesh",
             [](MeshedRegion& region) { region.label = 40; });
  TempFolder folder;
  write_with_region(folder.path(), Structure::cystic_duct, [](MeshedRegion& region) { region.voxel_volume *= 1.04; });
  EXPECT_EQ(describe(check_patient(folder.path())), "");
}

TEST(PatientCheck, ModelThatSaysSomethingElse) {
  expect_finding_in_text(false, "model.toml: young of the liver is 6400 Pa here and 5400 Pa in patient.toml",
                         "young = 5400.0", "young = 6400.0", "model.toml");
  expect_finding_in_text(false, "model.toml: young of the liver is 5400 Pa here and 6400 Pa in patient.toml",
                         "young = 5400.0", "young = 6400.0");
  expect_finding_in_text(false, "model.toml: holds other vertices", "vertices = [\n",
                         "vertices = [\n0, 1, 2, 3, 4, 5, ", "model.toml");
  expect_finding_in_text(false, "model.toml: has no material for the liver", "region = 1\n", "region = 2\n",
                         "model.toml");
  expect_finding_in_text(true, "model.toml:", "[[material]]", "[[material", "model.toml");
}

// ---- text ----

TEST(PatientCheck, MistakesInTheTextNameTheLine) {
  expect_finding_in_text(true, "patient.toml:", "[camera]", "[camera");
  expect_finding_in_text(true, "there is no structure \"galbladder\"; did you mean gallbladder?",
                         "name = \"gallbladder\"", "name = \"galbladder\"");
  expect_finding_in_text(true, "young = 0 must be > 0 Pa", "young = 5400.0", "young = 0");
  expect_finding_in_text(true, "poisson = 0.5 must lie between", "poisson = 0.45", "poisson = 0.5");
  expect_finding_in_text(true, "vertex 123456 is not in the mesh", "vertices = [\n", "vertices = [ 123456,\n");
  expect_finding_in_text(true, "has no surface to draw", "surface = \"surfaces/liver.ply\"\n", "");
  expect_finding_in_text(true, "surfaces/lever.ply: the file is missing", "surfaces/liver.ply", "surfaces/lever.ply");
}

TEST(PatientCheck, SeveralMistakesAreAllNamed) {
  TempFolder folder;
  write_small_patient(folder.path());
  std::string text = read_bytes(folder / "patient.toml");
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"diameter = 10.0", "diameter = 0.01"},
                                                        {"kind = \"peritoneum\"\nreason", "kind = \"skin\"\nreason"},
                                                        {"oblique = 30.0", "oblique = -30.0"}})
    text.replace(text.find(from), from.size(), to);
  write_bytes(folder / "patient.toml", text);
  EXPECT_EQ(check_patient(folder.path()).size(), 3U) << describe(check_patient(folder.path()));
}

// ---- materials ----

TEST(PatientCheck, SlipsOfUnitsInMaterials) {
  const auto material = [](Patient& p) -> TissueMaterial& { return p.materials[Structure::liver]; };
  expect_finding(false, "region \"liver\": young = 5.4 Pa is that of no soft tissue; were kPa meant? write 5400",
                 [&](Patient& p) { material(p).young = 5.4; });
  expect_finding(false, "were MPa meant? write 5400", [&](Patient& p) { material(p).young = 0.0054; });
  expect_finding(false, "young = 5.4e+09 Pa", [&](Patient& p) { material(p).young = 5.4e9; });
  expect_finding(false, "were g/cm3 meant? write 1060", [&](Patient& p) { material(p).density = 1.06; });
  expect_finding(false, "makes linear tetrahedra lock", [&](Patient& p) { material(p).poisson = 0.499; });
  expect_finding(false, "poisson = -0.2", [&](Patient& p) { material(p).poisson = -0.2; });
}

// ---- mesh and supports ----

TEST(PatientCheck, SupportsThatHoldNothingOrEverything) {
  expect_finding(true, "is held by nothing", [](Patient& p) {
    p.border_cuts.clear();
    p.attachments.erase(p.attachments.begin(), p.attachments.begin() + 2);
  });
  expect_finding(true, "is held at 2 vertices only", [](Patient& p) {
    p.border_cuts.clear();
    attachment(p, 0).vertices.resize(2);
    p.attachments.erase(p.attachments.begin() + 1);
  });
  expect_finding(true, "is held at 5 vertices that lie on one line, about which it turns freely", [](Patient& p) {
    p.border_cuts.clear();
    std::vector<VertexId>& held = attachment(p, 0).vertices;
    std::erase_if(held, [&](VertexId v) {
      const Vec3 from = p.mesh.position(v) - cube_place(2, 3, 8);
      return std::abs(from.y()) > 1e-9 || from.x() < -1e-9 || from.x() > 4 * cube + 1e-9;
    });
    p.attachments.erase(p.attachments.begin() + 1);
  });
  expect_finding(true, "all of the cystic duct is held", [](Patient& p) {
    std::vector<VertexId>& held = attachment(p, 0).vertices;
    for (std::size_t t = 0; t < p.mesh.tet_count(); ++t)
      if (p.mesh.regions[t] == label_of(Structure::cystic_duct))
        held.insert(held.end(), p.mesh.tets[t].begin(), p.mesh.tets[t].end());
    std::sort(held.begin(), held.end());
    held.erase(std::unique(held.begin(), held.end()), held.end());
  });
  expect_finding(false, "attachment \"gallbladder: peritoneum\": all its vertices are fixed", [](Patient& p) {
    attachment(p, 1).vertices = attachment(p, 2).vertices;
    p.attachments[2].vertices.resize(3);
  });
  expect_finding(false, "border cut of the liver: no vertex on the cut face is held",
                 [](Patient& p) { p.border_cuts[0].point.z() += 0.02; });
  expect_finding(true, "only liver, fat and bed may be cut",
                 [](Patient& p) { p.border_cuts[0].structure = Structure::gallbladder; });
}

TEST(PatientCheck, MeshesThatCantBeOperatedOn) {
  // The gallbladder's tets given to the duct: still sound, but nothing to take out.
  expect_finding(true, "mesh.msh: there is no gallbladder: nothing to operate on", [](Patient& p) {
    for (std::int32_t& region : p.mesh.regions)
      if (region == 2) region = 8;
    p.mesh.region_names.erase(2);
    p.materials.erase(Structure::gallbladder);
    p.appearances.erase(Structure::gallbladder);
    p.landmarks = small_landmarks(p.lines);
    std::reverse(p.lines[0].points.begin(), p.lines[0].points.end());  // as there is nothing to run towards
    std::reverse(p.lines[0].radii.begin(), p.lines[0].radii.end());
  });
  expect_finding(true, "mesh.msh: the gallbladder is in 2 pieces", [](Patient& p) {
    for (std::size_t t = 0; t < p.mesh.tet_count(); ++t) {
      const Vec3& top = p.mesh.position(p.mesh.tets[t][3]);
      if (p.mesh.regions[t] != 1 || top.z() < cube_place(0, 0, 8).z() - 1e-6) continue;
      p.mesh.regions[t] = 2;
      break;
    }
  });
  expect_finding(false, "mesh.msh: has flat tetrahedra", [](Patient& p) {
    for (Vec3& x : p.mesh.positions)
      if ((x - cube_place(0, 0, 8)).norm() < 1e-9) x.z() -= 0.97 * cube;
    for (Attachment& each : p.attachments)
      std::erase_if(each.vertices,
                    [&](VertexId v) { return (p.mesh.position(v) - cube_place(0, 0, 8)).norm() < cube; });
  });
}

TEST(PatientCheck, SurfaceThatTouchesItself) {
  // A cube of liver that hangs on the rest by an edge.
  expect_finding(true, "the outer surface is no closed manifold", [](Patient& p) {
    const TetMesh& old = p.mesh;
    TetMesh mesh = cell_mesh(12, 6, 8, {12 * cube, 6 * cube, 8 * cube}, [](int i, int j, int k) {
      if (i == 0 && j == 5 && k == 7) return 0;
      if (i == 1 && j == 4 && k == 7) return 0;
      return static_cast<int>(structure_of_cube(i, j, k));
    });
    for (Vec3& x : mesh.positions) x += corner_of_cubes;
    mesh.region_names = old.region_names;
    p.mesh = mesh;
    const Patient fresh = small_patient();
    for (Attachment& each : p.attachments) {
      std::vector<VertexId> again;
      for (const VertexId v : each.vertices)
        for (std::size_t w = 0; w < mesh.vertex_count(); ++w)
          if ((mesh.positions[w] - fresh.mesh.position(v)).norm() < 1e-9) again.emplace_back(w);
      each.vertices = again;
    }
  });
}

// ---- ports ----

TEST(PatientCheck, Ports) {
  expect_finding(true, "port \"epigastric\": it lies inside the liver",
                 [](Patient& p) { port_named(p, "epigastric").position = cube_place(6.3, 3.2, 6.4); });
  expect_finding(true, "port \"midclavicular\": it lies 5 mm away from port \"epigastric\"", [](Patient& p) {
    port_named(p, "midclavicular").position = port_named(p, "epigastric").position + Vec3(0, 0, 0.005);
  });
  expect_finding(true, "port \"epigastric\": it lies 4",
                 [](Patient& p) { port_named(p, "epigastric").position.y() += 0.3; });
  expect_finding(true, "port \"epigastric\": its position lies within a millimetre of the origin; it looks like metres",
                 [](Patient& p) { port_named(p, "epigastric").position *= 1e-3; });
  expect_finding(true, "there is no port named \"camera\"",
                 [](Patient& p) { port_named(p, "camera").name = "camrea"; });
  expect_finding(true, "there are two ports of this name",
                 [](Patient& p) { port_named(p, "epigastric").name = "midclavicular"; });
  expect_finding(true, "there is no [[port]]", [](Patient& p) { p.landmarks.ports.clear(); });
}

// ---- camera and triangle ----

TEST(PatientCheck, Camera) {
  expect_finding(true, "camera: it looks 180 degrees away from Calot's triangle", [](Patient& p) {
    CameraPose& camera = p.landmarks.camera;
    camera.target = 2 * camera.tip - camera.target;
  });
  expect_finding(true, "camera: its tip lies 2", [](Patient& p) {
    CameraPose& camera = p.landmarks.camera;
    camera.tip += 0.16 * (camera.tip - camera.target).normalized();
  });
  expect_finding(true, "camera: its tip lies inside the liver",
                 [](Patient& p) { p.landmarks.camera.tip = cube_place(2.2, 3.3, 7.1); });
  expect_finding(false, "camera: the liver hides Calot's triangle from it", [](Patient& p) {
    CameraPose& camera = p.landmarks.camera;
    camera.tip = camera.target + Vec3(0.003, 0.002, 0.09);
    camera.up = Vec3(0, 1, 0);
  });
  expect_finding(true, "camera: its tip lies within a millimetre of the origin; it looks like metres",
                 [](Patient& p) { p.landmarks.camera.tip *= 1e-3; });
}

TEST(PatientCheck, Triangle) {
  expect_finding(true, "calot_triangle: liver_corner lies ",
                 [](Patient& p) { p.landmarks.triangle.liver_corner += Vec3(0, 0.1, 0); });
  expect_finding(true, "it looks like metres: write millimetres",
                 [](Patient& p) { p.landmarks.triangle.duct_corner *= 1e-3; });
  expect_finding(true, "its corners don't span a triangle",
                 [](Patient& p) { p.landmarks.triangle.liver_corner = p.landmarks.triangle.neck_corner; });
}

// ---- clips and cuts ----

TEST(PatientCheck, ClipsOffTheirTube) {
  expect_finding(true, "clip \"cystic duct, clip 2\": it lies 7 mm away from the middle of the cystic duct",
                 [](Patient& p) { clip(p, 1).position.y() -= 7e-3; });
  expect_finding(true, "clip \"cystic duct, clip 2\": it lies ", [](Patient& p) { clip(p, 1).position *= 1e-3; });
  expect_finding(true, "it looks like metres", [](Patient& p) { clip(p, 1).position *= 1e-3; });
  expect_finding(true, "its arc_length is 11 mm, but its position is at 14 mm of the cystic duct's 22.5 mm",
                 [](Patient& p) { clip(p, 1).position = place_at(duct_line(), 14e-3).point; });
  expect_finding(true, "its arc_length is 80 mm", [](Patient& p) { clip(p, 2).arc_length = 80e-3; });
  expect_finding(true, "its direction isn't that of the cystic duct",
                 [](Patient& p) { clip(p, 1).direction = -clip(p, 1).direction; });
  expect_finding(false, "its radius is 15 mm", [](Patient& p) { clip(p, 1).radius = 15e-3; });
}

TEST(PatientCheck, OrderOfClipsAndCuts) {
  expect_finding(true, "it comes after \"cystic duct, clip 1\" in the file, but lies before it", [](Patient& p) {
    std::swap(clip(p, 0), clip(p, 1));
    std::swap(clip(p, 0).name, clip(p, 1).name);
  });
  const auto cut_at = [](double arc) {
    return [arc](Patient& p) { p.landmarks.cuts[0] = site_on(duct_line(), "cystic duct, cut", arc); };
  };
  expect_finding(true, "cut \"cystic duct, cut\": it is not between the clips: 1 on the side that stays", cut_at(9e-3));
  expect_finding(true, "it is not between the clips: 0 on the side that stays", cut_at(3e-3));
  expect_finding(true, "3 on the side that stays, 0 on the gallbladder's", cut_at(20e-3));
  expect_finding(true, "there is no [[cut]] of the cystic duct",
                 [](Patient& p) { p.landmarks.cuts.erase(p.landmarks.cuts.begin()); });
  expect_finding(true, "it is not between the clips: 1 on the side that stays",
                 [](Patient& p) { p.landmarks.clips.erase(p.landmarks.clips.begin()); });
}

TEST(PatientCheck, TubesThatMustNotOrCantBeDivided) {
  expect_finding(true, "the common bile duct must not be divided", [](Patient& p) {
    p.landmarks.clips.push_back(site_on(p.lines[2], "common bile duct, clip 1", 5e-3));
  });
  expect_finding(true, "the mesh has no second cystic artery", [](Patient& p) {
    clip(p, 0).tube = Structure::second_cystic_artery;
    p.landmarks.clips.insert(p.landmarks.clips.begin(), small_patient().landmarks.clips[0]);
  });
  expect_finding(true, "clips and cuts of the cystic artery: there is no centreline",
                 [](Patient& p) { p.lines.erase(p.lines.begin() + 1); });
}

}  // namespace
