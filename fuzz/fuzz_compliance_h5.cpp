// C.h5 with any contents: a compliance or an InputError. The bytes choose what the file holds, not its HDF5 encoding,
// which is the library's business.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "calot/base/error.h"
#include "calot/compliance/compliance_file.h"
#include "calot/compliance/hdf5_file.h"
#include "tests/support/files.h"
#include "tests/support/models.h"

namespace {

using namespace calot;

const Model& model() {
  static const Model the_model =
      test::make_model(test::two_tets(), 0.01, [](const Vec3& p) { return p.z() < 0 || p.x() == 1; });
  return the_model;
}

/// Draws choices from the input; zeros once it is used up.
class Choices {
 public:
  Choices(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  std::uint8_t byte() {
    if (left_ == 0) return 0;
    --left_;
    return *data_++;
  }
  /// True for one byte in `of`.
  bool one_in(int of) { return byte() % of == of - 1; }
  double real() {
    std::uint64_t bits = 0;
    for (int i = 0; i < 8; ++i) bits = bits << 8 | byte();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  std::string text() {
    std::string words(byte() % 70, ' ');
    for (char& c : words) c = static_cast<char>(byte());
    return words.substr(0, words.find('\0'));
  }
  /// The values, some changed, one dropped or one added.
  template <class T>
  std::vector<T> spoiled(std::vector<T> values) {
    if (one_in(4) && !values.empty()) values[byte() % values.size()] = static_cast<T>(static_cast<std::int8_t>(byte()));
    if (one_in(8) && !values.empty()) values.pop_back();
    if (one_in(8)) values.push_back(static_cast<T>(byte()));
    if (one_in(16)) values.clear();
    return values;
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

void write_attributes(detail::H5Writer& file, Choices& choose) {
  if (!choose.one_in(16)) file.attribute("calot_version", choose.one_in(6) ? choose.text() : "0.1.0");
  if (!choose.one_in(4)) file.attribute("model_sha256", choose.one_in(6) ? choose.text() : model().fingerprint());
  if (!choose.one_in(6)) file.attribute("mesh_sha256", choose.one_in(3) ? choose.text() : "");
  if (!choose.one_in(8)) file.attribute("kind", choose.one_in(4) ? choose.text() : "dynamic");
  if (choose.one_in(8))
    file.attribute("time_step", choose.text());
  else
    file.attribute("time_step", choose.one_in(4) ? choose.real() : 0.01);
  for (const char* key : {"rayleigh_mass", "rayleigh_stiffness"})
    if (!choose.one_in(8)) file.attribute(key, choose.one_in(4) ? choose.real() : 0.0);
  if (choose.one_in(4)) file.attribute("approximate", choose.byte());
}

void write_matrix(detail::H5Writer& file, Choices& choose, const char* path, std::uint64_t rows,
                  std::uint64_t columns) {
  if (choose.one_in(8)) rows += choose.byte() % 4;
  if (choose.one_in(8)) columns += choose.byte() % 4;
  std::vector<double> values(rows * columns, 1e-3);
  for (int k = choose.byte() % 20; k > 0; --k) values[choose.byte() * values.size() / 256] = choose.real();
  file.matrix(path, rows, columns, 1 + choose.byte() % rows, choose.one_in(2));
  file.write_rows(0, rows, values.data());
}

void write_file(const std::filesystem::path& path, Choices& choose) {
  detail::H5Writer file(path, path.string());
  write_attributes(file, choose);
  if (!choose.one_in(16)) file.vector("/node_ids", choose.spoiled<std::uint32_t>({0, 1, 2, 3, 4}));
  if (choose.one_in(2)) {
    file.group("/factor");
    // Vertices 0, 2 and 3 are free: one supernode of three.
    file.vector("/factor/ordering", choose.spoiled<std::uint32_t>({3, 0, 2}));
    file.vector("/factor/supernode_start", choose.spoiled<std::uint32_t>({0, 1, 3}));
    file.vector("/factor/row_start", choose.spoiled<std::int64_t>({0, 2, 2}));
    file.vector("/factor/rows", choose.spoiled<std::uint32_t>({1, 2}));
    if (!choose.one_in(8)) write_matrix(file, choose, "/factor/values", 1, 1024);
  } else if (!choose.one_in(16)) {
    write_matrix(file, choose, "/compliance", 15, 15);
  }
  file.close();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const test::TempFolder folder;
  Choices choose(data, size);
  write_file(folder / "C.h5", choose);
  try {
    load_full_compliance(folder / "C.h5", model());
  } catch (const InputError&) {
  }
  try {
    load_compliance(folder / "C.h5", model()).solve({{VertexId(3), {0, 0, 1}}});
  } catch (const InputError&) {
  }
  return 0;
}
