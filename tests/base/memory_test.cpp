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

TEST(Memory, RecycledBuffersComeBack) {
  const double* first = nullptr;
  {
    Buffer a = Buffer::recycled(100000);
    EXPECT_EQ(a.size(), 100000u);
    a.data()[0] = a.data()[99999] = 3;
    first = a.data();
  }
  Buffer b = Buffer::recycled(90000);  // fits where the first was
  EXPECT_EQ(b.data(), first);
  EXPECT_EQ(b.size(), 90000u);
  Buffer c = Buffer::recycled(90000);  // while b lives, another
  EXPECT_NE(c.data(), b.data());
  c.data()[89999] = 1;
  EXPECT_EQ(Buffer::recycled(0).size(), 0u);
  Buffer large = Buffer::recycled(std::size_t{1} << 23);  // not kept: from the system, and zero
  EXPECT_EQ(large.data()[(std::size_t{1} << 23) - 1], 0);
  EXPECT_THROW(Buffer::recycled(std::size_t{1} << 58), FailedError);
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
