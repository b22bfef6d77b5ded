// What the element types of Gmsh and VTK files are to us.
#include <algorithm>

#include "calot/mesh/raw_mesh.h"

namespace calot::detail {
namespace {

using enum ElementUse;

struct Row {
  int type;
  ElementKind kind;
};

constexpr auto gmsh_rows = std::to_array<Row>({
    {1, {ignored, 2, "lines"}},
    {2, {ignored, 3, "triangles"}},
    {3, {ignored, 4, "quadrangles"}},
    {4, {tet, 4, "tetrahedra"}},
    {5, {other_volume, 8, "hexahedra"}},
    {6, {other_volume, 6, "prisms"}},
    {7, {other_volume, 5, "pyramids"}},
    {8, {ignored, 3, "second-order lines"}},
    {9, {ignored, 6, "second-order triangles"}},
    {10, {ignored, 9, "second-order quadrangles"}},
    {11, {second_order_tet, 10, "second-order tetrahedra"}},
    {12, {other_volume, 27, "second-order hexahedra"}},
    {13, {other_volume, 18, "second-order prisms"}},
    {14, {other_volume, 14, "second-order pyramids"}},
    {15, {ignored, 1, "points"}},
    {16, {ignored, 8, "second-order quadrangles"}},
    {17, {other_volume, 20, "second-order hexahedra"}},
    {18, {other_volume, 15, "second-order prisms"}},
    {19, {other_volume, 13, "second-order pyramids"}},
    {20, {ignored, 9, "third-order triangles"}},
    {21, {ignored, 10, "third-order triangles"}},
    {26, {ignored, 4, "third-order lines"}},
    {29, {second_order_tet, 20, "third-order tetrahedra"}},
    {30, {second_order_tet, 35, "fourth-order tetrahedra"}},
    {31, {second_order_tet, 56, "fifth-order tetrahedra"}},
});

constexpr auto vtk_rows = std::to_array<Row>({
    {0, {ignored, 0, "empty cells"}},
    {1, {ignored, 1, "points"}},
    {2, {ignored, 0, "point sets"}},
    {3, {ignored, 2, "lines"}},
    {4, {ignored, 0, "polylines"}},
    {5, {ignored, 3, "triangles"}},
    {6, {ignored, 0, "triangle strips"}},
    {7, {ignored, 0, "polygons"}},
    {8, {ignored, 4, "pixels"}},
    {9, {ignored, 4, "quadrangles"}},
    {10, {tet, 4, "tetrahedra"}},
    {11, {other_volume, 8, "voxels"}},
    {12, {other_volume, 8, "hexahedra"}},
    {13, {other_volume, 6, "prisms"}},
    {14, {other_volume, 5, "pyramids"}},
    {15, {other_volume, 10, "pentagonal prisms"}},
    {16, {other_volume, 12, "hexagonal prisms"}},
    {21, {ignored, 3, "second-order lines"}},
    {22, {ignored, 6, "second-order triangles"}},
    {23, {ignored, 8, "second-order quadrangles"}},
    {24, {second_order_tet, 10, "second-order tetrahedra"}},
    {25, {other_volume, 20, "second-order hexahedra"}},
    {26, {other_volume, 15, "second-order prisms"}},
    {27, {other_volume, 13, "second-order pyramids"}},
    {28, {ignored, 9, "second-order quadrangles"}},
    {29, {other_volume, 27, "second-order hexahedra"}},
    {34, {ignored, 7, "second-order triangles"}},
    {42, {other_volume, 0, "polyhedra"}},
    {68, {ignored, 0, "Lagrange curves"}},
    {69, {ignored, 0, "Lagrange triangles"}},
    {70, {ignored, 0, "Lagrange quadrangles"}},
    {71, {second_order_tet, 0, "Lagrange tetrahedra"}},
});

template <class Rows>
ElementKind find_type(const Rows& rows, int type) {
  const auto row = std::find_if(rows.begin(), rows.end(), [type](const Row& r) { return r.type == type; });
  return row == rows.end() ? ElementKind{} : row->kind;
}

}  // namespace

ElementKind gmsh_element(int type) {
  return find_type(gmsh_rows, type);
}
ElementKind vtk_cell(int type) {
  return find_type(vtk_rows, type);
}

}  // namespace calot::detail
