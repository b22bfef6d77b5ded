// What holds the organs of a field built from blocks.
#include "calot/patient/attachments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "calot/base/error.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/surface.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

constexpr double mm = 1e-3, cell = 5e-3;

struct Block {
  Structure structure;
  std::array<int, 6> cells;  // from and to along x, y, z
};

/// A liver over a gallbladder with its bed, ducts that leave below, an artery that comes from the left.
const std::vector<Block> blocks{{Structure::liver, {2, 26, 2, 22, 16, 28}},
                                {Structure::gallbladder_bed, {14, 18, 12, 20, 15, 16}},
                                {Structure::gallbladder, {14, 18, 12, 20, 9, 15}},
                                {Structure::cystic_duct, {10, 14, 12, 14, 11, 13}},
                                {Structure::common_bile_duct, {8, 10, 12, 14, 0, 12}},
                                {Structure::common_hepatic_duct, {8, 10, 12, 14, 12, 16}},
                                {Structure::right_hepatic_artery, {0, 8, 12, 13, 13, 14}}};
const Block loose_fat{Structure::hepatocystic_fat, {24, 26, 10, 12, 5, 7}};

TetMesh mesh_of(const std::vector<Block>& all) {
  return cell_mesh(28, 24, 30, cell * Vec3(28, 24, 30), [&](int i, int j, int k) {
    for (const auto& [structure, c] : all)
      if (i >= c[0] && i < c[1] && j >= c[2] && j < c[3] && k >= c[4] && k < c[5]) return int{label_of(structure)};
    return 0;
  });
}

CompletedAnatomy anatomy_of(bool cut_above = false) {
  CompletedAnatomy a;
  a.labels.grid.size = {28, 24, 30};
  a.labels.grid.to_world.linear() = Eigen::Matrix3d::Identity() * 1e-3;
  a.ct.grid = a.labels.grid;
  const auto line = [](Structure s, const Vec3& from, const Vec3& to, double radius) {
    return Centreline{std::string(name_of(s)), {cell * from, cell * to}, {radius, radius}};
  };
  a.lines = {line(Structure::cystic_duct, {9, 13, 12}, {15, 13, 12}, 5 * mm),
             line(Structure::common_bile_duct, {9, 13, 12}, {9, 13, 0}, 5 * mm),
             line(Structure::common_hepatic_duct, {9, 13, 12}, {9, 13, 16}, 5 * mm),
             line(Structure::right_hepatic_artery, {0, 12.5, 13.5}, {8, 12.5, 13.5}, 2.5 * mm)};
  if (cut_above) a.border_cuts = {{Structure::liver, 2, true, cell * Vec3(14, 12, 28), Vec3::UnitZ(), 0.012}};
  return a;
}

const Attachment* named(const std::vector<Attachment>& all, const std::string& name) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Attachment& a) { return a.name.find(name) != std::string::npos; });
  return found == all.end() ? nullptr : &*found;
}

void expect_ascending(const std::vector<Attachment>& all, const TetMesh& mesh) {
  for (const Attachment& a : all) {
    ASSERT_FALSE(a.vertices.empty());
    EXPECT_FALSE(a.reason.empty());
    for (std::size_t v = 0; v < a.vertices.size(); ++v) {
      EXPECT_LT(a.vertices[v].index(), mesh.vertex_count());
      EXPECT_TRUE(v == 0 || a.vertices[v - 1] < a.vertices[v]);
    }
  }
}

TEST(Attachments, TheLiverHangsOnItsBackAndDomeFarFromTheField) {
  const TetMesh mesh = mesh_of(blocks);
  const std::vector<Attachment> all = find_attachments(mesh, anatomy_of());
  expect_ascending(all, mesh);
  const Attachment* liver = named(all, "liver: bare area");
  ASSERT_NE(liver, nullptr);
  EXPECT_EQ(liver->kind, AttachmentKind::fixed);
  std::set<VertexId> others;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    if (mesh.regions[t] != label_of(Structure::liver)) others.insert(mesh.tets[t].begin(), mesh.tets[t].end());
  for (const VertexId v : liver->vertices) {
    const Vec3 p = mesh.position(v);
    EXPECT_TRUE(p.z() > 28 * cell - 1e-9 || p.y() < 2 * cell + 1e-9) << p.transpose();
    for (const VertexId o : others) EXPECT_GE((mesh.position(o) - p).norm(), 30 * mm - 1e-9);
  }
  EXPECT_GT(liver->vertices.size(), 300u);
}

TEST(Attachments, DuctsAndArteriesAreHeldWhereTheyLeaveAndNowhereElse) {
  const TetMesh mesh = mesh_of(blocks);
  const std::vector<Attachment> all = find_attachments(mesh, anatomy_of());
  const Attachment* bile = named(all, "common bile duct: lower end");
  ASSERT_NE(bile, nullptr);
  EXPECT_EQ(bile->vertices.size(), 9u);
  for (const VertexId v : bile->vertices) EXPECT_EQ(mesh.position(v).z(), 0);
  const Attachment* artery = named(all, "right hepatic artery: left end");
  ASSERT_NE(artery, nullptr);
  for (const VertexId v : artery->vertices) EXPECT_LE(mesh.position(v).x(), cell + 1e-9);
  EXPECT_EQ(named(all, "common hepatic duct"), nullptr) << "it ends in the liver";
  EXPECT_EQ(named(all, "cystic duct"), nullptr);
  EXPECT_EQ(named(all, "common bile duct: upper"), nullptr);
  EXPECT_EQ(named(all, "artery: right"), nullptr);
}

TEST(Attachments, PeritoneumRunsWhereGallbladderBedAndLiverMeetOutside) {
  const TetMesh mesh = mesh_of(blocks);
  const std::vector<Attachment> all = find_attachments(mesh, anatomy_of());
  const Attachment* line = named(all, "peritoneum");
  ASSERT_NE(line, nullptr);
  EXPECT_EQ(line->kind, AttachmentKind::peritoneum);
  // Two rims of 4 x 8 cells, under the liver and on the gallbladder.
  EXPECT_EQ(line->vertices.size(), 2u * 2u * (4 + 8));
  for (const VertexId v : line->vertices) {
    const Vec3 c = mesh.position(v) / cell;
    EXPECT_TRUE(std::abs(c.z() - 15) < 1e-9 || std::abs(c.z() - 16) < 1e-9);
    const bool rim_x = std::abs(c.x() - 14) < 1e-9 || std::abs(c.x() - 18) < 1e-9;
    const bool rim_y = std::abs(c.y() - 12) < 1e-9 || std::abs(c.y() - 20) < 1e-9;
    EXPECT_TRUE(rim_x || rim_y);
  }
}

TEST(Attachments, ACutFaceIsHeldWhole) {
  const TetMesh mesh = mesh_of(blocks);
  const std::vector<Attachment> all = find_attachments(mesh, anatomy_of(true));
  const Attachment* face = named(all, "cut face of the CT: upper");
  ASSERT_NE(face, nullptr);
  EXPECT_EQ(face->vertices.size(), 25u * 21u);
  for (const VertexId v : face->vertices) EXPECT_NEAR(mesh.position(v).z(), 28 * cell, 1e-12);
  EXPECT_EQ(named(find_attachments(mesh, anatomy_of()), "cut face"), nullptr);
}

TEST(Attachments, ACutFaceOfFatIsHeldToo) {
  std::vector<Block> with_fat = blocks;
  with_fat.push_back({Structure::hepatocystic_fat, {14, 18, 0, 12, 11, 13}});
  CompletedAnatomy anatomy = anatomy_of();
  anatomy.border_cuts = {{Structure::hepatocystic_fat, 1, false, cell * Vec3(16, 0, 12), -Vec3::UnitY(), 200e-6}};
  const TetMesh mesh = mesh_of(with_fat);
  const std::vector<Attachment> all = find_attachments(mesh, anatomy);
  const Attachment* face = named(all, "cut face of the CT: back (posterior) end of the hepatocystic fat");
  ASSERT_NE(face, nullptr);
  EXPECT_EQ(face->kind, AttachmentKind::fixed);
  EXPECT_EQ(face->vertices.size(), 5u * 3u);
  for (const VertexId v : face->vertices) EXPECT_NEAR(mesh.position(v).y(), 0, 1e-12);
}

TEST(Attachments, EveryPartHasSomethingFixed) {
  std::vector<Block> with_fat = blocks;
  with_fat.push_back(loose_fat);
  const TetMesh mesh = mesh_of(with_fat);
  const std::vector<Attachment> all = find_attachments(mesh, anatomy_of());
  expect_ascending(all, mesh);
  EXPECT_NE(named(all, "loose piece: hepatocystic fat"), nullptr);
  const Parts parts = face_connected_parts(mesh);
  EXPECT_EQ(parts.count(), 2u);
  for (const std::vector<VertexId>& part : parts.vertices) {
    std::size_t fixed = 0;
    for (const Attachment& a : all)
      for (const VertexId v : a.vertices)
        fixed += a.kind == AttachmentKind::fixed && std::binary_search(part.begin(), part.end(), v);
    EXPECT_GE(fixed, 3u);
  }
}

TEST(Attachments, AGallbladderThatNothingHoldsIsRefused) {
  std::vector<Block> apart = blocks;
  std::erase_if(apart, [](const Block& b) {
    return b.structure == Structure::gallbladder_bed || b.structure == Structure::cystic_duct;
  });
  const std::string message = message_of([&] { find_attachments(mesh_of(apart), anatomy_of()); });
  EXPECT_NE(message.find("gallbladder"), std::string::npos) << message;
  EXPECT_NE(message.find("held by nothing"), std::string::npos) << message;
}

TEST(Attachments, ASmallLiverIsHeldNearerToTheField) {
  const std::vector<Block> small{{Structure::liver, {12, 20, 12, 20, 16, 21}},
                                 {Structure::gallbladder, {14, 18, 14, 18, 9, 16}}};
  const TetMesh mesh = mesh_of(small);
  const std::vector<Attachment> all = find_attachments(mesh, anatomy_of());
  const Attachment* liver = named(all, "liver: bare area");
  ASSERT_NE(liver, nullptr);
  EXPECT_NE(liver->reason.find("20 mm or farther"), std::string::npos) << liver->reason;
}

}  // namespace
