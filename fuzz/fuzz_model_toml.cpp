// model.toml with anything in it, beside a sound mesh: a model or an InputError.
#include <cstddef>
#include <cstdint>

#include "calot/base/error.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace {

const calot::test::TempFolder& folder_with_mesh() {
  static const calot::test::TempFolder folder;
  static const bool written = [] {
    calot::TetMesh mesh = calot::test::two_tets();
    mesh.region_names = {{1, "one"}, {2, "two"}};
    calot::write_mesh(folder / "m.msh", mesh);
    return true;
  }();
  (void)written;
  return folder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto path = folder_with_mesh() / "model.toml";
  calot::test::write_bytes(path, {reinterpret_cast<const char*>(data), size});
  try {
    const calot::Model model = calot::load_model(path);
    // What can be read can be written, and stays the same.
    calot::save_model(folder_with_mesh() / "again.toml", model, "m.msh");
  } catch (const calot::InputError&) {
    return 0;
  }
  return 0;
}
