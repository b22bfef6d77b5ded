// Spoiled files: whatever happens to a valid file's bytes, it is read or refused with an InputError; nothing else.
#include <gtest/gtest.h>

#include "calot/base/error.h"
#include "calot/mesh/raw_mesh.h"
#include "calot/mesh/writers.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

TetMesh seed_mesh() {
  TetMesh mesh = two_tets();
  mesh.region_names = {{1, "one"}, {2, "number two"}};
  return mesh;
}

struct Seed {
  std::string name, bytes;
  std::function<void(std::string_view)> parse;
};

void PrintTo(const Seed& seed, std::ostream* out) {
  *out << seed.name;
}

std::vector<Seed> seeds() {
  const TetMesh mesh = seed_mesh();
  const Surface surface = boundary_surface(mesh);
  const std::vector<VertexArray> arrays{{"u", 1, {1, 2, 3, 4, 5}}};
  const auto volume = [](auto parse) { return [parse](std::string_view bytes) { parse(bytes, "x", 1.0); }; };
  using detail::VtuFormat;
  std::vector<Seed> all;
  for (const bool binary : {false, true}) {
    const std::string kind = binary ? "_binary" : "_ascii";
    all.push_back({"msh22" + kind, detail::format_msh22(mesh, arrays, binary), volume(detail::parse_msh)});
    all.push_back({"msh41" + kind, detail::format_msh41(mesh, arrays, binary), volume(detail::parse_msh)});
    all.push_back({"vtk" + kind, detail::format_vtk(mesh, arrays, binary), volume(detail::parse_vtk)});
    all.push_back({"stl" + kind, detail::format_stl(surface, binary, "x"), volume(detail::parse_stl)});
    all.push_back({"ply" + kind, detail::format_ply(surface, binary), volume(detail::parse_ply)});
  }
  all.push_back({"obj", detail::format_obj(surface), volume(detail::parse_obj)});
  all.push_back({"vtu_ascii", detail::format_vtu(mesh, arrays, VtuFormat::ascii), volume(detail::parse_vtu)});
  all.push_back({"vtu_base64", detail::format_vtu(mesh, arrays, VtuFormat::base64), volume(detail::parse_vtu)});
  all.push_back({"vtu_appended", detail::format_vtu(mesh, arrays, VtuFormat::appended), volume(detail::parse_vtu)});
  all.push_back({"vtu_zlib", detail::format_vtu(mesh, arrays, VtuFormat::zlib), volume(detail::parse_vtu)});
  return all;
}

/// One to four random changes: bits, bytes, numbers, cuts, repeats.
std::string spoil(std::string bytes, Random& random) {
  static const std::vector<std::string> words{"-1", "0",  "99999999999", "18446744073709551615", "nan", "1e400",
                                              " ",  "\n", "\""};
  const std::size_t changes = 1 + random.below(4);
  for (std::size_t i = 0; i < changes && !bytes.empty(); ++i) {
    const std::size_t at = random.below(bytes.size());
    switch (random.below(7)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(random.below(256));
        break;
      case 2:
        bytes[at] = static_cast<char>('0' + random.below(10));
        break;
      case 3:
        bytes.resize(at);
        break;
      case 4:
        bytes.erase(at, 1 + random.below(16));
        break;
      case 5:
        bytes.insert(at, bytes.substr(random.below(bytes.size()), random.below(64)));
        break;
      default:
        bytes.replace(at, random.below(4), words[random.below(words.size())]);
        break;
    }
  }
  return bytes;
}

class Mutation : public testing::TestWithParam<Seed> {};

TEST_P(Mutation, EndsInAMeshOrAnInputError) {
  ASSERT_NO_THROW(GetParam().parse(GetParam().bytes));
  Random random(20240229);
  int refused = 0;
  constexpr int runs = 4000;
  for (int run = 0; run < runs; ++run) {
    const std::string bytes = spoil(GetParam().bytes, random);
    try {
      GetParam().parse(bytes);
    } catch (const InputError&) {
      ++refused;
    } catch (const std::exception& error) {
      FAIL() << "run " << run << ": " << error.what() << "\n" << bytes;
    }
  }
  EXPECT_GT(refused, runs / 10);
}

INSTANTIATE_TEST_SUITE_P(Formats, Mutation, testing::ValuesIn(seeds()),
                         [](const auto& param) { return param.param.name; });

}  // namespace
