// What ITK makes of our files is what 3D Slicer and its kin will see.
#include <gtest/gtest.h>
#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkNiftiImageIO.h>

#include "calot/image/label_map.h"
#include "tests/support/files.h"
#include "tests/support/volumes.h"

namespace calot {
namespace {

TEST(Itk, sees_our_labels_at_the_same_place) {
  const test::TempFolder folder;
  const LabelMap map = test::map_of(test::oblique_grid({5, 6, 7}, {0.001, 0.002, 0.003}),
                                    [](int i, int j, int k) { return static_cast<Label>(i + 5 * j + 30 * k); });
  write_label_map(folder / "map.nii.gz", map);
  using Image = itk::Image<std::uint16_t, 3>;
  const auto reader = itk::ImageFileReader<Image>::New();
  reader->SetImageIO(itk::NiftiImageIO::New());
  reader->SetFileName((folder / "map.nii.gz").string());
  reader->Update();
  const Image* image = reader->GetOutput();
  for (const auto& [i, j, k] : {std::array{0, 0, 0}, std::array{4, 5, 6}, std::array{1, 3, 2}}) {
    const Image::IndexType index{{i, j, k}};
    EXPECT_EQ(image->GetPixel(index), i + 5 * j + 30 * k);
    Image::PointType lps;
    image->TransformIndexToPhysicalPoint(index, lps);
    const Eigen::Vector3d theirs(-lps[0] / 1e3, -lps[1] / 1e3, lps[2] / 1e3);  // LPS mm → RAS m
    EXPECT_LT((theirs - map.grid.to_world * Eigen::Vector3d(i, j, k)).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace calot
