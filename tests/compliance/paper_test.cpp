// The paper's Algorithms 1 and 2 against a transcription of them, entry by entry.
#include <gtest/gtest.h>

#include <set>

#include "calot/compliance/full_compliance.h"
#include "calot/mesh/parts.h"
#include "tests/support/accuracy.h"

namespace calot {
namespace {

FullCompliance numbered(std::size_t vertices) {
  FullCompliance c;
  c.vertices = vertices;
  c.values.resize(c.size() * c.size());
  for (std::size_t i = 0; i < c.values.size(); ++i) c.values[i] = static_cast<double>(i + 1);
  return c;
}

// Algorithm 1 as printed: copy every 3×3 block whose two vertices stay.
FullCompliance algorithm_1(const FullCompliance& before, const std::set<std::size_t>& deleted) {
  FullCompliance after;
  after.vertices = before.vertices - deleted.size();
  for (std::size_t i = 0; i < before.vertices; ++i) {
    if (deleted.contains(i)) continue;
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t j = 0; j < before.vertices; ++j) {
        if (deleted.contains(j)) continue;
        for (std::size_t b = 0; b < 3; ++b) after.values.push_back(before.row(3 * i + a)[3 * j + b]);
      }
  }
  return after;
}

// Algorithm 2 as printed: for all pairs, if their parts differ, the block is zero.
void algorithm_2(FullCompliance& c, const std::vector<std::uint32_t>& part) {
  for (std::size_t i = 0; i < c.vertices; ++i)
    for (std::size_t j = 0; j < c.vertices; ++j)
      if (part[i] != part[j])
        for (std::size_t a = 0; a < 3; ++a)
          for (std::size_t b = 0; b < 3; ++b) c.row(3 * i + a)[3 * j + b] = 0;
}

TEST(Paper, AlgorithmOneStrikesRowsAndColumns) {
  for (const std::set<std::size_t>& deleted :
       {std::set<std::size_t>{}, {0}, {9}, {3, 4, 5}, {0, 2, 9}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}}) {
    FullCompliance c = numbered(10);
    std::vector<VertexId> ids;
    for (const std::size_t v : deleted) ids.push_back(VertexId(v));
    const FullCompliance expected = algorithm_1(c, deleted);
    paper_delete_vertices(c, ids);
    EXPECT_EQ(c.vertices, expected.vertices);
    EXPECT_EQ(c.values, expected.values);
  }
}

TEST(Paper, AlgorithmTwoZeroesBetweenParts) {
  FullCompliance c = numbered(40), expected = c;
  std::vector<std::uint32_t> part;
  for (std::uint32_t v = 0; v < 40; ++v) part.push_back(v * 7 % 3);
  paper_zero_between_parts(c, part);
  algorithm_2(expected, part);
  EXPECT_EQ(c.values, expected.values);
}

TEST(Paper, UpdateAfterACutIsBothAlgorithms) {
  Model model = test::biliary_model(0.02);
  const FullCompliance before = precompute(model).full();
  const StiffnessChange change = model.apply(
      {test::tets_where(model.mesh(), [](const Vec3& c) { return c.x() > 0.012 && c.x() < 0.028; }), {}, {}});
  ASSERT_FALSE(change.struck.empty());
  FullCompliance updated = before;
  paper_update(updated, change.struck, model.mesh());
  std::set<std::size_t> deleted;
  for (const VertexId v : change.struck) deleted.insert(v.index());
  FullCompliance expected = algorithm_1(before, deleted);
  const Parts parts = face_connected_parts(model.mesh());
  ASSERT_GE(parts.count(), 2u);
  std::vector<std::uint32_t> part(model.mesh().vertex_count());
  for (std::size_t p = 0; p < parts.count(); ++p)
    for (const VertexId v : parts.vertices[p]) part[v.index()] = static_cast<std::uint32_t>(p);
  algorithm_2(expected, part);
  EXPECT_EQ(updated.values, expected.values);
}

// What the paper leaves in: each part keeps the uncut stiffness. Wrong by percents where the exact update is right.
TEST(Paper, ZeroingIsApproximate) {
  Model model = test::biliary_model(0.02);
  Compliance exact = precompute(model);
  FullCompliance paper = exact.full();
  const StiffnessChange change = model.apply(
      {test::tets_where(model.mesh(), [](const Vec3& c) { return c.x() > 0.0145 && c.x() < 0.0205; }), {}, {}});
  paper_update(paper, change.struck, model.mesh());
  exact.update(change);
  const VertexId at_face = test::cut_face(change).front();
  const Eigen::MatrixXd truth = exact.columns(std::vector{dof_of(at_face, 0)});
  double error = 0;
  for (std::size_t r = 0; r < paper.size(); ++r)
    error = std::max(error, std::abs(paper.row(r)[3 * at_face.index()] - truth(static_cast<Eigen::Index>(r), 0)));
  EXPECT_GT(error, 0.02 * truth.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace calot
