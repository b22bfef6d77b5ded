// What check_patient has to say about mesh, materials and supports.
#include <algorithm>
#include <cmath>
#include <set>

#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "calot/mesh/surface.h"
#include "calot/patient/patient_check.h"
#include "calot/patient/support_area.h"

namespace calot::detail {
namespace {

constexpr double smallest_angle = 10, largest_angle = 165;  // [°]
const std::string anew = "make the folder anew with calot patient";

void check_needed(const std::set<std::int32_t>& present, const std::string& file, Findings& findings) {
  const auto has = [&](Structure s) { return present.contains(label_of(s)); };
  for (const Structure s : {Structure::liver, Structure::gallbladder, Structure::cystic_duct})
    if (!has(s))
      findings.error(file, "there is no " + std::string(name_of(s)) + ": nothing to operate on",
                     "segment it, or draw it with a centreline, and run calot patient again");
  if (!has(Structure::common_bile_duct) && !has(Structure::common_hepatic_duct))
    findings.error(file, "there is no bile duct for the cystic duct to join",
                   "draw the common bile duct with a centreline and run calot patient again");
}

TetMesh only(const TetMesh& mesh, std::int32_t region) {
  TetMesh part;
  part.positions = mesh.positions;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (mesh.regions[t] != region) continue;
    part.tets.push_back(mesh.tets[t]);
    part.regions.push_back(region);
  }
  return part;
}

std::vector<std::uint8_t> fixed_vertices(const Patient& patient) {
  std::vector<std::uint8_t> fixed(patient.mesh.vertex_count(), 0);
  for (const Attachment& attachment : patient.attachments)
    if (attachment.kind == AttachmentKind::fixed)
      for (const VertexId v : attachment.vertices) fixed[v.index()] = 1;
  return fixed;
}

void check_held(const Patient& patient, const std::vector<std::uint8_t>& fixed, Findings& findings) {
  const Parts parts = face_connected_parts(patient.mesh);
  for (std::size_t p = 0; p < parts.count(); ++p) {
    std::vector<VertexId> held;
    for (const VertexId v : parts.vertices[p])
      if (fixed[v.index()] != 0) held.push_back(v);
    if (spans_an_area(patient.mesh, held)) continue;
    std::set<std::int32_t> regions;
    for (const TetId t : parts.tets[p]) regions.insert(patient.mesh.regions[t.index()]);
    std::string names;
    for (const std::int32_t region : regions) names += (names.empty() ? "" : ", ") + region_text(region);
    const std::string what =
        "the part with " + names + " (" + std::to_string(parts.tets[p].size()) + " tetrahedra) is ";
    const std::string to_do = "fix vertices of it in an [[attachment]] of kind \"fixed\"";
    if (held.empty())
      findings.error("patient.toml, attachments", what + "held by nothing", to_do);
    else if (held.size() < 3)
      findings.error("patient.toml, attachments",
                     what + "held at " + std::to_string(held.size()) + (held.size() == 1 ? " vertex" : " vertices") +
                         " only, about which it turns freely",
                     to_do + ", three or more");
    else
      findings.error("patient.toml, attachments",
                     what + "held at " + std::to_string(held.size()) +
                         " vertices that lie on one line, about which it turns freely",
                     to_do + ", off that line");
  }
}

void check_movable(const Patient& patient, const std::vector<std::uint8_t>& fixed, Findings& findings) {
  std::set<std::int32_t> movable;
  for (std::size_t t = 0; t < patient.mesh.tet_count(); ++t)
    for (const VertexId v : patient.mesh.tets[t])
      if (fixed[v.index()] == 0) movable.insert(patient.mesh.regions[t]);
  for (const std::int32_t region : std::set(patient.mesh.regions.begin(), patient.mesh.regions.end()))
    if (!movable.contains(region))
      findings.error("patient.toml, attachments", "all of the " + region_text(region) + " is held: it can't be moved",
                     "take vertices out of the attachments of kind \"fixed\"");
}

void check_both_kinds(const Patient& patient, const std::vector<std::uint8_t>& fixed, Findings& findings) {
  for (const Attachment& attachment : patient.attachments) {
    if (attachment.kind == AttachmentKind::fixed) continue;
    const auto both = std::count_if(attachment.vertices.begin(), attachment.vertices.end(),
                                    [&](VertexId v) { return fixed[v.index()] != 0; });
    if (both == static_cast<std::ptrdiff_t>(attachment.vertices.size()))
      findings.warning("patient.toml, attachment \"" + brief(attachment.name) + "\"",
                       "all its vertices are fixed by other attachments: the membrane does nothing",
                       "take them out of one or the other");
  }
}

}  // namespace

std::string region_text(std::int32_t region) {
  for (const Structure s : all_structures())
    if (label_of(s) == region) return std::string(name_of(s));
  return "region " + std::to_string(region);
}

void check_mesh(const Patient& patient, const std::string& file, Findings& findings) {
  const TetMesh& mesh = patient.mesh;
  const std::set<std::int32_t> present(mesh.regions.begin(), mesh.regions.end());
  check_needed(present, file, findings);
  const MeshProblems problems = validate(mesh);
  if (!problems.describe().empty()) findings.error(file, problems.describe(), anew);
  for (const std::int32_t region : present) {
    const std::size_t parts = face_connected_parts(only(mesh, region)).count();
    if (parts > 1)
      findings.error(file, "the " + region_text(region) + " is in " + std::to_string(parts) + " pieces", anew);
  }
  const ManifoldReport outside = check_manifold(boundary_surface(mesh));
  if (!outside.closed_manifold())
    findings.error(file,
                   "the outer surface is no closed manifold (" + std::to_string(outside.nonmanifold_edges) +
                       " edges and " + std::to_string(outside.nonmanifold_vertices) +
                       " vertices where it touches itself)",
                   anew);
  const Quality q = quality(mesh);
  if (q.min_dihedral < smallest_angle || q.max_dihedral > largest_angle)
    findings.warning(file,
                     "has flat tetrahedra: angles from " + short_number(q.min_dihedral) + " to " +
                         short_number(q.max_dihedral) + " degrees, where 10 to 165 are wanted",
                     "it works, less accurately; calot patient with more tetrahedra gives better ones");
}

void check_materials(const Patient& patient, Findings& findings) {
  for (const auto& [s, material] : patient.materials) {
    const std::string where = "patient.toml, region \"" + std::string(name_of(s)) + "\"";
    if (material.young < 50 || material.young > 1e9)
      findings.warning(where, "young = " + short_number(material.young) + " Pa is that of no soft tissue",
                       material.young < 1    ? "were MPa meant? write " + short_number(material.young * 1e6)
                       : material.young < 50 ? "were kPa meant? write " + short_number(material.young * 1e3)
                                             : "give Young's modulus in Pa");
    if (material.density < 200 || material.density > 3000)
      findings.warning(where, "density = " + short_number(material.density) + " kg/m3 is that of no soft tissue",
                       material.density < 10 ? "were g/cm3 meant? write " + short_number(material.density * 1e3)
                                             : "use 920 (fat) to 1060 (liver)");
    if (material.poisson > 0.49)
      findings.warning(where, "poisson = " + short_number(material.poisson) + " makes linear tetrahedra lock",
                       "use 0.45; 0.49 at most");
    if (material.poisson < 0)
      findings.warning(where, "poisson = " + short_number(material.poisson) + " is that of no soft tissue",
                       "use e.g. 0.45");
  }
}

void check_attachments(const Patient& patient, Findings& findings) {
  const std::vector<std::uint8_t> fixed = fixed_vertices(patient);
  check_held(patient, fixed, findings);
  check_movable(patient, fixed, findings);
  check_both_kinds(patient, fixed, findings);
  for (const BorderCut& cut : patient.border_cuts) {
    const std::string where = "patient.toml, border cut of the " + std::string(name_of(cut.structure));
    const bool may_be = cut.structure == Structure::liver || cut.structure == Structure::hepatocystic_fat ||
                        cut.structure == Structure::gallbladder_bed;
    if (!may_be)
      findings.error(where, "only liver, fat and bed may be cut by the CT's border",
                     "use a CT that holds the whole of it");
    constexpr double reach = 5e-3;  // the working grid and the mesh's facets move the face a little
    bool held = false;
    for (std::size_t v = 0; v < fixed.size() && !held; ++v)
      held = fixed[v] != 0 && std::abs((patient.mesh.positions[v] - cut.point).dot(cut.normal)) < reach;
    if (!held)
      findings.warning(where, "no vertex on the cut face is held",
                       "fix the vertices there: the rest of the organ, which the CT doesn't show, holds them");
  }
}

}  // namespace calot::detail
