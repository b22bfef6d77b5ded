// Bad mesh files as the command line meets them; the readers' own tests go deeper.
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace calot::test {
namespace {

class BadMesh : public testing::Test {
 protected:
  /// The mesh file with these bytes is refused by the commands that read it, and nothing is written.
  void refused(const std::string& bytes, std::vector<std::string> words) {
    write_bytes(folder.mesh(), bytes);
    words.push_back("organ.msh");
    expect_refused(calot_run({"precompute", folder.model(), "-o", folder.compliance()}), 2, words);
    expect_refused(calot_run({"convert", folder.mesh(), folder.name("organ.vtu")}), 2, words);
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"model.toml", "organ.msh"}));
  }
  /// The sound file with one line of a section replaced; line 0 is the one after the section's name.
  std::string with_line(const std::string& section, int line, const std::string& text) const {
    std::string bytes = sound;
    std::size_t place = bytes.find(section);
    for (int i = 0; i <= line; ++i) place = bytes.find('\n', place) + 1;
    return bytes.replace(place, bytes.find('\n', place) - place, text);
  }
  ModelFolder folder;
  std::string sound = read_bytes(folder.mesh());
};

TEST_F(BadMesh, EmptyTruncatedOrGarbage) {
  refused("", {});
  refused(sound.substr(0, sound.size() / 3), {});
  refused(sound.substr(0, sound.size() - 200), {});
  refused(std::string(3000, '\xee'), {});
  refused("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", {});
}

TEST_F(BadMesh, HugeCounts) {
  refused(with_line("$Nodes", 0, "4000000000"), {":"});
  refused(with_line("$Elements", 0, "99999999999999"), {":"});
}

TEST_F(BadMesh, BadCoordinatesAndIndices) {
  refused(with_line("$Nodes", 1, "1 nan 0 0"), {":"});
  refused(with_line("$Nodes", 1, "1 0 zero 0"), {":"});
  refused(with_line("$Nodes", 2, "1 0 0 0"), {":"});
  refused(with_line("$Elements", 1, "1 4 2 4 4 1 2 3 99999"), {":"});
  refused(with_line("$Elements", 1, "1 4 2 4 4 1 2 3 3"), {});
  refused(with_line("$Elements", 1, "1 77 2 4 4 1 2 3 4"), {"77"});
}

TEST_F(BadMesh, InvertedAndFlatTetsAreCountedAndNamed) {
  const std::size_t place = sound.find('\n', sound.find("$Elements") + 10) + 1;
  const std::string line = sound.substr(place, sound.find('\n', place) - place);
  std::istringstream words(line);
  std::vector<std::string> w{std::istream_iterator<std::string>(words), {}};
  ASSERT_EQ(w.size(), 9u) << line;
  std::swap(w[7], w[8]);
  std::string turned;
  for (const std::string& word : w) turned += word + " ";
  refused(with_line("$Elements", 1, turned), {"1 inverted", "(0)"});
}

TEST_F(BadMesh, WithoutTets) {
  refused(
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n1 2 2 1 1 "
      "1 2 3\n$EndElements\n",
      {"tetrahedra"});
}

}  // namespace
}  // namespace calot::test
