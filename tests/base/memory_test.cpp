#include "calot/base/memory.h"

#include <gtest/gtest.h>

#include "calot/base/error.h"
#include "tests/support/files.h"

namespace calot {
namespace {

TEST(Memory, IsReadable) {
  EXPECT_EQ(readable_bytes(12), "12 B");
  EXPECT_EQ(readable_bytes(409'400'000), "409 MB");
  EXPECT_EQ(readable_bytes(1'500'000'000), "1.5 GB");
}

TEST(Memory, TooMuchIsRefusedWithBothNumbers) {
  EXPECT_GT(available_memory(), 0u);
  EXPECT_NO_THROW(require_memory(1 << 20, "it"));
  const std::string message = test::message_of([] { require_memory(std::uint64_t{1} << 60, "the compliance"); });
  EXPECT_NE(message.find("the compliance needs 1153 PB and "), std::string::npos) << message;
  EXPECT_NE(message.find("free"), std::string::npos) << message;
}

TEST(Memory, BuffersMoveAndStartAtZero) {
  Buffer a(1000);
  EXPECT_EQ(a.data()[999], 0);
  a.data()[5] = 3;
  Buffer b(std::move(a));
  EXPECT_EQ(b.data()[5], 3);
  EXPECT_EQ(a.size(), 0u);
  EXPECT_THROW(Buffer(std::size_t{1} << 58), FailedError);
}

}  // namespace
}  // namespace calot
