#include "calot/patient/attachments.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "calot/base/error.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/surface.h"
#include "calot/patient/border.h"
#include "calot/patient/support_area.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;

std::uint32_t bit(Structure s) {
  return 1u << label_of(s);
}
constexpr auto fat = Structure::hepatocystic_fat;
constexpr auto bed = Structure::gallbladder_bed;

/// Points in buckets, to ask whether any is near.
class NearPoints {
 public:
  explicit NearPoints(double reach) : reach_(reach) {}
  void add(const Vec3& p) { buckets_[key(p)].push_back(p); }
  [[nodiscard]] bool any_within(const Vec3& p, double distance) const {  // distance ≤ reach
    const auto [x, y, z] = key(p);
    for (int a = -1; a <= 1; ++a)
      for (int b = -1; b <= 1; ++b)
        for (int c = -1; c <= 1; ++c) {
          const auto found = buckets_.find({x + a, y + b, z + c});
          if (found == buckets_.end()) continue;
          for (const Vec3& q : found->second)
            if ((q - p).squaredNorm() < distance * distance) return true;
        }
    return false;
  }

 private:
  using Key = std::tuple<int, int, int>;
  [[nodiscard]] Key key(const Vec3& p) const {
    const auto of = [&](double x) { return static_cast<int>(std::floor(x / reach_)); };
    return {of(p[0]), of(p[1]), of(p[2])};
  }
  double reach_;
  std::map<Key, std::vector<Vec3>> buckets_;
};

class Finder {
 public:
  Finder(const TetMesh& mesh, const CompletedAnatomy& anatomy);
  std::vector<Attachment> run();

 private:
  void hold_liver();
  void hold_tube_ends();
  void hold_tube_end(Structure tube, const Centreline& line, bool last);
  void hold_cut_faces();
  void hold_peritoneum();
  void hold_parts();
  void add(const std::string& name, AttachmentKind kind, std::vector<VertexId> vertices, const std::string& reason);
  [[nodiscard]] std::vector<VertexId> vertices_of(Structure s) const;
  [[nodiscard]] bool touches(VertexId v, Structure s) const { return (touching_[v.index()] & bit(s)) != 0; }
  [[nodiscard]] bool spans_an_area(const std::vector<VertexId>& vertices) const {
    return detail::spans_an_area(mesh_, vertices);
  }

  const TetMesh& mesh_;
  const CompletedAnatomy& anatomy_;
  std::vector<std::uint32_t> touching_;  // of each vertex: bits of the structures of its tets
  std::vector<bool> outer_;              // of each vertex
  std::vector<Vec3> normals_;            // of outer vertices
  std::vector<Attachment> found_;
};

Finder::Finder(const TetMesh& mesh, const CompletedAnatomy& anatomy) : mesh_(mesh), anatomy_(anatomy) {
  touching_.assign(mesh.vertex_count(), 0);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    for (const VertexId v : mesh.tets[t])
      if (mesh.regions[t] > 0 && mesh.regions[t] < 32) touching_[v.index()] |= 1u << mesh.regions[t];
  outer_.assign(mesh.vertex_count(), false);
  normals_.assign(mesh.vertex_count(), Vec3::Zero());
  const Surface surface = boundary_surface(mesh);
  const std::vector<Vec3> normals = vertex_normals(surface, surface.positions);
  for (std::size_t v = 0; v < normals.size(); ++v) {
    outer_[surface.vertex_of_mesh[v].index()] = true;
    normals_[surface.vertex_of_mesh[v].index()] = normals[v];
  }
}

void Finder::add(const std::string& name, AttachmentKind kind, std::vector<VertexId> vertices,
                 const std::string& reason) {
  if (vertices.empty()) return;
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  found_.push_back({name, kind, std::move(vertices), reason});
}

std::vector<VertexId> Finder::vertices_of(Structure s) const {
  std::vector<VertexId> vertices;
  for (std::size_t v = 0; v < touching_.size(); ++v)
    if (touches(VertexId(v), s)) vertices.emplace_back(v);
  return vertices;
}

void Finder::hold_liver() {
  const Vec3 back_and_up = Vec3(0, -1, 1).normalized();
  NearPoints field(30 * mm);
  for (std::size_t v = 0; v < touching_.size(); ++v)
    if ((touching_[v] & ~bit(Structure::liver)) != 0) field.add(mesh_.positions[v]);
  const std::vector<VertexId> liver = vertices_of(Structure::liver);
  for (const double distance : {30 * mm, 20 * mm, 12 * mm, 6 * mm}) {
    std::vector<VertexId> held;
    for (const VertexId v : liver)
      if (outer_[v.index()] && normals_[v.index()].dot(back_and_up) > 0.5 &&
          !field.any_within(mesh_.position(v), distance))
        held.push_back(v);
    if (!spans_an_area(held)) continue;
    add("liver: bare area and diaphragm", AttachmentKind::fixed, held,
        "coronary and triangular ligaments hold the liver's back and dome; " +
            std::to_string(std::lround(distance / mm)) + " mm or farther from the other organs");
    return;
  }
}

void Finder::hold_tube_ends() {
  for (const Structure s : all_structures()) {
    if (!is_tube(s) || s == Structure::cystic_duct) continue;
    for (const Centreline& line : anatomy_.lines)
      if (line.name == name_of(s) && line.points.size() >= 2)
        for (const bool last : {false, true}) hold_tube_end(s, line, last);
  }
}

/// The vertices of a tube at one end of its line, unless it ends in another organ.
void Finder::hold_tube_end(Structure tube, const Centreline& line, bool last) {
  const std::vector<VertexId> vertices = vertices_of(tube);
  if (vertices.size() < 3) return;
  const LinePlace end = place_at(line, last ? length(line) : 0);
  const Vec3 outward = last ? end.direction : Vec3(-end.direction);
  const double near = 3 * end.radius + 3 * mm;
  std::vector<std::pair<double, VertexId>> along;
  for (const VertexId v : vertices) {
    const Vec3 from = mesh_.position(v) - end.point;
    if (from.norm() < near) along.emplace_back(-from.dot(outward), v);
  }
  if (along.empty()) return;  // drawn, but meshed away there
  std::sort(along.begin(), along.end());
  const double depth = std::max(0.5 * end.radius, 0.7 * mm);
  std::vector<VertexId> cap;
  for (const auto& [behind, v] : along)
    if (behind < along.front().first + depth || cap.size() < 6) cap.push_back(v);
  const std::uint32_t loose = bit(tube) | bit(fat) | bit(bed);
  const auto joined =
      std::count_if(cap.begin(), cap.end(), [&](VertexId v) { return (touching_[v.index()] & ~loose) != 0; });
  if (3 * joined > std::ssize(cap) || !spans_an_area(cap)) return;
  const Vec3 middle = place_at(line, length(line) / 2).point;
  const Vec3 apart = end.point - middle;
  Eigen::Index axis = 0;
  apart.cwiseAbs().maxCoeff(&axis);
  static constexpr std::array<const char*, 6> sides{"left", "right", "rear", "front", "lower", "upper"};
  add(std::string(name_of(tube)) + ": " + sides[2 * static_cast<std::size_t>(axis) + (apart[axis] > 0 ? 1 : 0)] +
          " end",
      AttachmentKind::fixed, cap, "it goes on beyond what is modelled");
}

void Finder::hold_cut_faces() {
  const Vec3 spacing = anatomy_.labels.grid.spacing();
  const double tolerance = std::max(1.5 * mm, 2 * spacing.maxCoeff());
  for (const BorderCut& cut : anatomy_.border_cuts) {
    std::vector<VertexId> on_face;
    for (const VertexId v : vertices_of(cut.structure))
      if (outer_[v.index()] && (mesh_.position(v) - cut.point).dot(cut.normal) > -tolerance) on_face.push_back(v);
    add("cut face of the CT: " + side_name(anatomy_.ct.grid, cut.axis, cut.upper) + " end of the " +
            std::string(name_of(cut.structure)),
        AttachmentKind::fixed, on_face, "the organ goes on beyond the CT");
  }
}

void Finder::hold_peritoneum() {
  std::vector<VertexId> line;
  const std::uint32_t gallbladder = bit(Structure::gallbladder) | bit(Structure::gallbladder_wall);
  for (std::size_t v = 0; v < touching_.size(); ++v) {
    const std::uint32_t t = touching_[v];
    const int groups = ((t & gallbladder) != 0) + ((t & bit(bed)) != 0) + ((t & bit(Structure::liver)) != 0);
    if (outer_[v] && groups >= 2) line.emplace_back(v);
  }
  add("peritoneum along the gallbladder", AttachmentKind::peritoneum, line,
      "it passes from the gallbladder onto the liver; the surgeon opens it along this line");
}

/// Every part needs something fixed, or it drifts.
void Finder::hold_parts() {
  const Parts parts = face_connected_parts(mesh_);
  std::vector<bool> fixed(mesh_.vertex_count(), false);
  for (const Attachment& a : found_)
    for (const VertexId v : a.vertices)
      if (a.kind == AttachmentKind::fixed) fixed[v.index()] = true;
  Vec3 gallbladder = Vec3::Zero();
  const std::vector<VertexId> of_gallbladder = vertices_of(Structure::gallbladder);
  for (const VertexId v : of_gallbladder) gallbladder += mesh_.position(v) / static_cast<double>(of_gallbladder.size());
  for (std::size_t p = 0; p < parts.count(); ++p) {
    std::vector<VertexId> held;
    for (const VertexId v : parts.vertices[p])
      if (fixed[v.index()]) held.push_back(v);
    if (spans_an_area(held)) continue;
    std::set<Structure> inside;
    for (const TetId t : parts.tets[p]) inside.insert(static_cast<Structure>(mesh_.regions[t.index()]));
    for (const Structure s : {Structure::gallbladder, Structure::cystic_duct, Structure::liver})
      if (inside.contains(s))
        throw FailedError("the part of the mesh with the " + std::string(name_of(s)), "is held by nothing",
                          "label what joins it to the liver or the bile duct, or draw its duct");
    std::vector<std::pair<double, VertexId>> far;
    for (const VertexId v : parts.vertices[p]) far.emplace_back(-(mesh_.position(v) - gallbladder).norm(), v);
    std::sort(far.begin(), far.end());
    std::vector<VertexId> chosen;
    for (const auto& [distance, v] : far) {
      if (10 * chosen.size() >= far.size() && spans_an_area(chosen)) break;
      chosen.push_back(v);
    }
    add("far end of a loose piece: " + std::string(name_of(*inside.begin())), AttachmentKind::fixed, chosen,
        "this piece touches no other by a face, so that nothing else holds it");
  }
}

std::vector<Attachment> Finder::run() {
  hold_liver();
  hold_tube_ends();
  hold_cut_faces();
  hold_peritoneum();
  hold_parts();
  return found_;
}

}  // namespace

bool detail::spans_an_area(const TetMesh& mesh, const std::vector<VertexId>& vertices) {
  if (vertices.size() < 3) return false;
  Vec3 mean = Vec3::Zero();
  for (const VertexId v : vertices) mean += mesh.position(v) / static_cast<double>(vertices.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const VertexId v : vertices) spread += (mesh.position(v) - mean) * (mesh.position(v) - mean).transpose();
  const Vec3 eigen = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  return eigen[1] > 1e-4 * eigen[2] && eigen[2] > 0;
}

std::vector<Attachment> find_attachments(const TetMesh& mesh, const CompletedAnatomy& anatomy) {
  return Finder(mesh, anatomy).run();
}

}  // namespace calot
