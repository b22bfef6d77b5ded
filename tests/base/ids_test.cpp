#include "calot/base/ids.h"

#include <gtest/gtest.h>

#include <type_traits>

namespace calot {
namespace {

TEST(Ids, DoNotMix) {
  EXPECT_FALSE((std::is_convertible_v<VertexId, TetId>));
  EXPECT_FALSE((std::is_constructible_v<TetId, VertexId>));
  EXPECT_FALSE((std::is_convertible_v<int, VertexId>));
}

TEST(Ids, DofsAndVertices) {
  EXPECT_EQ(dof_of(VertexId(7), 2), DofId(23));
  EXPECT_EQ(vertex_of(DofId(23)), VertexId(7));
  EXPECT_FALSE(VertexId::none().valid());
  EXPECT_LT(VertexId(3), VertexId(4));
}

}  // namespace
}  // namespace calot
