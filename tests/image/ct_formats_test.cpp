// CTs in NIfTI and NRRD, in every orientation, as nibabel and ITK write them.
#include <gtest/gtest.h>
#include <itkNrrdImageIO.h>

#include "calot/image/ct_file.h"
#include "calot/image/label_map.h"
#include "tests/image/dicom_fixture.h"
#include "tests/image/hu_field.h"
#include "tests/support/volumes.h"

namespace calot {
namespace {

using test::expect_in_place;
using test::TempFolder;

Progress silent;

TEST(CtFile, nifti_in_all_48_orientations_straight_and_oblique_and_every_type) {
  const TempFolder folder;
  test::run_python(folder, test::write_series + R"(
import itertools, nibabel as nib
turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
kinds = itertools.cycle(['int16', 'int32', 'float32', 'float64', 'int64'])
n = 0
for base in (np.eye(3), turn):
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1, -1), repeat=3):
            affine = np.eye(4)
            affine[:3, :3] = (base @ np.diag([1.5, 1.75, 2.25]) * signs)[:, order]
            affine[:3, 3] = [12.5, -20.25, 87]
            ijk = np.stack(np.meshgrid(np.arange(6), np.arange(5), np.arange(4), indexing='ij'), -1)
            ras = ijk @ affine[:3, :3].T + affine[:3, 3]
            kind = next(kinds)
            image = nib.Nifti1Image(hu(ras * [-1, -1, 1]).astype(kind), affine, dtype=kind)
            nib.save(image, f'ct{n}' + ('.nii' if n % 3 == 0 else '.nii.gz'))
            n += 1
scaled = nib.Nifti1Image((hu(ras * [-1, -1, 1]) * 4 + 4000).astype('<u2'), affine)
scaled.header.set_slope_inter(0.25, -1000)
nib.save(scaled, 'scaled.nii.gz')
)");
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    const std::string name = entry.path().filename().string();
    if (name.find(".nii") == std::string::npos || name.starts_with("scaled")) continue;
    ++files;
    const CtFile file = read_ct(entry.path(), silent);
    EXPECT_EQ(file.format, "NIfTI");
    EXPECT_EQ(file.inputs, std::vector<std::string>{entry.path().string()});
    expect_in_place(file.ct, name);
  }
  EXPECT_EQ(files, 96);
}

TEST(CtFile, nifti_slope_and_intercept_rounding_and_clamping) {
  const TempFolder folder;
  test::run_python(folder, R"(
import numpy as np, nibabel as nib
data = np.zeros((2, 2, 2), '<i2')
data[0, 0, 0], data[1, 0, 0], data[0, 1, 0], data[1, 1, 0], data[0, 0, 1] = -2001, 3, 5, 32767, -32768
image = nib.Nifti1Image(data, np.eye(4))
nib.save(image, 'plain.nii')
raw = bytearray(open('plain.nii', 'rb').read())
import struct
raw[112:120] = struct.pack('<ff', 0.5, -10)
open('half.nii', 'wb').write(raw)
raw[112:120] = struct.pack('<ff', 4, 0)
open('four.nii', 'wb').write(raw)
)");
  const auto half = read_ct(folder / "half.nii", silent).ct.hounsfield;
  EXPECT_EQ(half, (std::vector<std::int16_t>{-1011, -9, -8, 16374, -16394, -10, -10, -10})) << "halves away from zero";
  const auto four = read_ct(folder / "four.nii", silent).ct.hounsfield;
  EXPECT_EQ(four, (std::vector<std::int16_t>{-8004, 12, 20, 32767, -32768, 0, 0, 0}));
}

TEST(CtFile, our_own_ct_comes_back) {
  const TempFolder folder;
  CtImage ct{test::oblique_grid({7, 6, 5}, {0.0007, 0.0008, 0.0015}), {}};
  test::for_each_voxel(ct.grid, [&](std::size_t, const Eigen::Vector3d& place) {
    ct.hounsfield.push_back(static_cast<std::int16_t>(test::hu_at(place)));
  });
  write_ct(folder / "ct.nii.gz", ct);
  EXPECT_EQ(read_ct(folder / "ct.nii.gz", silent).ct.hounsfield, ct.hounsfield);
}

TEST(CtFile, several_members_in_one_gzip_file_as_bgzip_writes_them) {
  const TempFolder folder;
  CtImage ct{test::oblique_grid({7, 6, 5}, {0.0017, 0.0018, 0.0015}), {}};
  test::for_each_voxel(ct.grid, [&](std::size_t, const Eigen::Vector3d& place) {
    ct.hounsfield.push_back(static_cast<std::int16_t>(test::hu_at(place)));
  });
  write_ct(folder / "ct.nii", ct);
  test::run_python(folder, R"(
import gzip
raw = open('ct.nii', 'rb').read()
open('ct.nii.gz', 'wb').write(b''.join(gzip.compress(raw[b:b + 100]) for b in range(0, len(raw), 100)))
open('short.nii.gz', 'wb').write(b''.join(gzip.compress(raw[b:b + 100]) for b in range(0, len(raw) - 200, 100)))
)");
  EXPECT_EQ(read_ct(folder / "ct.nii.gz", silent).ct.hounsfield, ct.hounsfield);
  const std::string message = test::message_of([&] { read_ct(folder / "short.nii.gz", silent); });
  EXPECT_NE(message.find("short.nii.gz: is truncated"), std::string::npos) << message;
}

TEST(CtFile, a_series_is_refused_where_there_is_no_dicom) {
  const TempFolder folder;
  for (const std::string name : {"ct.nii.gz", "ct.nii", "ct.nrrd", "ct.nhdr"})
    EXPECT_EQ(test::message_of([&] { read_ct(folder / name, silent, "1.2.3"); }),
              "--series: goes with DICOM only; leave it out");
}

/// Writes the field with ITK (LPS), with the voxel axes along the columns of `direction`.
void write_with_itk(const std::string& path, const Eigen::Matrix3d& direction, bool compressed) {
  const Eigen::Vector3d spacing(1.5, 1.75, 2.25), origin(-12.5, 20.25, 87);
  const std::array<std::uint32_t, 3> size{6, 5, 4};
  const auto io = itk::NrrdImageIO::New();
  io->SetFileName(path);
  io->SetNumberOfDimensions(3);
  io->SetPixelType(itk::CommonEnums::IOPixel::SCALAR);
  io->SetComponentType(itk::CommonEnums::IOComponent::SHORT);
  io->SetNumberOfComponents(1);
  io->SetUseCompression(compressed);
  itk::ImageIORegion region(3);
  for (unsigned d = 0; d < 3; ++d) {
    io->SetDimensions(d, size[d]);
    io->SetSpacing(d, spacing[d]);
    io->SetOrigin(d, origin[d]);
    io->SetDirection(d, std::vector<double>{direction(0, d), direction(1, d), direction(2, d)});
    region.SetSize(d, size[d]);
  }
  io->SetIORegion(region);
  std::vector<std::int16_t> values;
  for (int v = 0; v < 120; ++v) {
    const Eigen::Vector3d index(v % 6, v / 6 % 5, v / 30), lps = origin + direction * spacing.cwiseProduct(index);
    values.push_back(static_cast<std::int16_t>(test::hu_at(1e-3 * Eigen::Vector3d(-lps[0], -lps[1], lps[2]))));
  }
  io->Write(values.data());
}

TEST(CtFile, nrrd_as_itk_writes_it_in_all_48_orientations_straight_and_oblique) {
  const TempFolder folder;
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized())).toRotationMatrix();
  std::array<int, 3> order{0, 1, 2};
  int files = 0;
  do {
    for (int signs = 0; signs < 8; ++signs)
      for (const bool oblique : {false, true}) {
        Eigen::Matrix3d direction = Eigen::Matrix3d::Zero();
        for (int d = 0; d < 3; ++d) direction(order[static_cast<std::size_t>(d)], d) = signs >> d & 1 ? -1 : 1;
        if (oblique) direction = turn * direction;
        const std::string name = "ct" + std::to_string(files) + (files % 5 == 0 ? ".nhdr" : ".nrrd");
        write_with_itk((folder / name).string(), direction, files % 2 == 1);
        const CtFile file = read_ct(folder / name, silent);
        EXPECT_EQ(file.format, "NRRD");
        EXPECT_EQ(file.inputs.size(), files % 5 == 0 ? 2u : 1u);
        expect_in_place(file.ct, name);
        ++files;
      }
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(files, 96);
}

}  // namespace
}  // namespace calot
