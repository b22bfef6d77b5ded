// DICOM series that pydicom wrote, every voxel at its place; ITK as second judge.
#include <gtest/gtest.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkImageSeriesReader.h>

#include <algorithm>

#include "calot/image/ct_file.h"
#include "tests/image/dicom_fixture.h"
#include "tests/image/hu_field.h"

namespace calot {
namespace {

using test::expect_in_place;
using test::run_python;
using test::TempFolder;
using test::write_series;

Progress silent;

bool has_note(const std::vector<std::string>& notes, const std::string& part) {
  return std::any_of(notes.begin(), notes.end(), [&](const auto& n) { return n.find(part) != std::string::npos; });
}

TEST(Dicom, reads_a_series_whatever_its_files_are_called) {
  const TempFolder folder;
  run_python(folder, write_series + R"(
series('ct', name=lambda k: ['IM0007', 'zz', 'a.dcm', 'b'][k])
open('ct/README.txt', 'w').write('nothing to see here ' * 50)
os.makedirs('ct/.cache')
open('ct/.hidden', 'w').write('x')
report = Dataset()
report.SOPClassUID, report.SOPInstanceUID, report.Modality = '1.2.840.10008.5.1.4.1.1.88.33', '1.2.3', 'SR'
report.SeriesInstanceUID = '1.2.9'
report.file_meta = FileMetaDataset()
report.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
report.file_meta.MediaStorageSOPClassUID, report.file_meta.MediaStorageSOPInstanceUID = report.SOPClassUID, '1.2.3'
report.is_little_endian, report.is_implicit_VR = True, False
nested = Dataset()
nested.ReferencedSOPInstanceUID, nested.PurposeOfReferenceCodeSequence = '1.2.4', [Dataset(), Dataset()]
nested['PurposeOfReferenceCodeSequence'].is_undefined_length = True
report.ReferencedImageSequence = [nested, nested]
report['ReferencedImageSequence'].is_undefined_length = True
report.save_as('ct/report.dcm', write_like_original=False)
report.Modality = report.SeriesInstanceUID = None
report.save_as('ct/DICOMDIR', write_like_original=False)
)");
  const CtFile file = read_ct(folder / "ct", silent);
  EXPECT_EQ(file.format, "DICOM");
  EXPECT_EQ(file.ct.grid.size, (std::array<std::size_t, 3>{6, 5, 4}));
  EXPECT_LT((file.ct.grid.spacing() - Eigen::Vector3d(1.5e-3, 2e-3, 3e-3)).norm(), 1e-12);
  EXPECT_LT((file.ct.grid.to_world.translation() - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 1e-12);
  expect_in_place(file.ct, "axial");
  EXPECT_EQ(file.inputs, (std::vector<std::string>{(folder / "ct/IM0007").string(), (folder / "ct/a.dcm").string(),
                                                   (folder / "ct/b").string(), (folder / "ct/zz").string()}));
  EXPECT_TRUE(has_note(file.notes, "3 files passed over"));
  EXPECT_TRUE(has_note(file.notes, "read: 4 slices, \"abdomen\""));
  const CtFile by_file = read_ct(folder / "ct/zz", silent);
  EXPECT_EQ(by_file.ct.hounsfield, file.ct.hounsfield);
}

TEST(Dicom, all_24_orientations_of_rows_and_columns_and_oblique_ones) {
  const TempFolder folder;
  run_python(folder, write_series + R"(
axes = [np.eye(3)[a] * s for a in range(3) for s in (1, -1)]
n = 0
for row in axes:
    for column in axes:
        if abs(row @ column) < 0.5:
            n += 1
            series(f'straight{n}', row=row, column=column, uid=f'1.2.3.{n}')
rng = np.random.default_rng(5)
for n in range(4):
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    series(f'oblique{n}', row=q[0], column=q[1], uid=f'1.2.4.{n}', name=lambda k: f'{97 * (k + 1) % 31}')
)");
  int folders = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    if (!entry.is_directory()) continue;
    ++folders;
    const CtFile file = read_ct(entry.path(), silent);
    EXPECT_EQ(file.ct.grid.size, (std::array<std::size_t, 3>{6, 5, 4}));
    expect_in_place(file.ct, entry.path().filename().string());
  }
  EXPECT_EQ(folders, 28);
}

TEST(Dicom, itk_sees_the_same_numbers_at_the_same_places) {
  const TempFolder folder;
  run_python(folder, write_series + R"(
turn = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0]
series('ct', row=turn[0], column=turn[1], shift=(0.5, -1000.5), name=lambda k: f'{k * 7 % 5}.dcm')
)");
  const CtFile file = read_ct(folder / "ct", silent);
  using Image = itk::Image<double, 3>;
  const auto names = itk::GDCMSeriesFileNames::New();
  names->SetDirectory((folder / "ct").string());
  const auto reader = itk::ImageSeriesReader<Image>::New();
  reader->SetImageIO(itk::GDCMImageIO::New());
  reader->SetFileNames(names->GetInputFileNames());
  reader->Update();
  const Image* image = reader->GetOutput();
  const VoxelGrid& grid = file.ct.grid;
  ASSERT_EQ(image->GetLargestPossibleRegion().GetNumberOfPixels(), grid.count());
  for (std::size_t v = 0; v < grid.count(); ++v) {
    const std::size_t i = v % grid.size[0], j = v / grid.size[0] % grid.size[1], k = v / (grid.size[0] * grid.size[1]);
    const Eigen::Vector3d ras =
        grid.to_world * Eigen::Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    Image::PointType lps;
    for (int d = 0; d < 3; ++d) lps[static_cast<unsigned>(d)] = (d < 2 ? -1e3 : 1e3) * ras[d];
    Image::IndexType index;
    ASSERT_TRUE(image->TransformPhysicalPointToIndex(lps, index));
    Image::PointType theirs;
    image->TransformIndexToPhysicalPoint(index, theirs);
    EXPECT_LT(theirs.EuclideanDistanceTo(lps), 1e-3);
    EXPECT_EQ(std::round(image->GetPixel(index)), file.ct.hounsfield[v]);
  }
}

TEST(Dicom, reads_every_compression_byte_order_and_packing) {
  const TempFolder folder;
  run_python(folder, write_series + R"(
big = dict(size=(32, 24, 3), spacing=(0.9, 0.8))
series('plain', **big)
series('implicit', syntax=ImplicitVRLittleEndian, **big)
series('big', syntax=ExplicitVRBigEndian, **big)
series('twelve', bits=(16, 12, 0), shift=(1, -1024), **big)
series('signed12', bits=(16, 12, 1), **big)
series('wide', bits=(32, 32, 1), **big)
series('byte', bits=(8, 8, 0), shift=(8, -1000), **big)
def overlay(ds, k):
    pixels = np.frombuffer(ds.PixelData, '<u2') | 0xF000
    ds.PixelData = pixels.astype('<u2').tobytes()
def with_sequence(ds, k):
    inner = Dataset()
    inner.TextValue = 'x' * 70000
    nested = Dataset()
    nested.CodeMeaning, nested.EquivalentCodeSequence = 'y', [inner]
    nested['EquivalentCodeSequence'].is_undefined_length = True
    ds.ProcedureCodeSequence = [nested, nested]
    ds['ProcedureCodeSequence'].is_undefined_length = k % 2 == 0
series('long_header', change=with_sequence, **big)
series('implicit_sequence', change=with_sequence, syntax=ImplicitVRLittleEndian, **big)
series('no_mark', **big)
for k in range(3):
    name = f'no_mark/slice{k:03}.dcm'
    ds = pydicom.dcmread(name)
    ds.file_meta = None
    pydicom.dcmwrite(name, ds, write_like_original=True)
    raw = open(name, 'rb').read()
    open(name, 'wb').write(raw[132:] if raw[128:132] == b'DICM' else raw)
series('overlay', bits=(16, 12, 0), shift=(1, -1024), change=overlay, **big)
)");
  for (const std::string from : {"plain", "twelve"})
    for (const std::string how : {"j2k", "jpeg", "rle", "jpegls", "raw"}) {
      const std::string to = from + "_" + how;
      std::filesystem::create_directory(folder / to);
      const std::string option = "--" + how;
      for (int k = 0; k < 3; ++k) {
        const std::string name = "/slice00" + std::to_string(k) + ".dcm";
        const auto result = test::run_command("cd '" + folder.path().string() + "' && gdcmconv " + option + " " + from +
                                              name + " " + to + name);
        ASSERT_EQ(result.status, 0) << to << ": " << result.output;
      }
    }
  const CtFile plain = read_ct(folder / "plain", silent);
  expect_in_place(plain.ct, "plain");
  int kinds = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_directory() || name == "byte") continue;
    ++kinds;
    EXPECT_EQ(read_ct(entry.path(), silent).ct.hounsfield, plain.ct.hounsfield) << name;
  }
  EXPECT_EQ(kinds, 20);
  const CtFile coarse = read_ct(folder / "byte", silent);
  for (std::size_t v = 0; v < plain.ct.grid.count(); ++v)
    ASSERT_NEAR(coarse.ct.hounsfield[v], plain.ct.hounsfield[v], 4.1);
}

TEST(Dicom, rounds_and_clamps) {
  const TempFolder folder;
  run_python(folder, write_series + R"(
series('steep', shift=(100, 50.5), values=lambda p: np.where(p[..., 0] < -5, -1000000, 1000 * p[..., 1] + 400000))
)");
  const CtFile file = read_ct(folder / "steep", silent);
  EXPECT_EQ(*std::min_element(file.ct.hounsfield.begin(), file.ct.hounsfield.end()), -32768);
  EXPECT_EQ(*std::max_element(file.ct.hounsfield.begin(), file.ct.hounsfield.end()), 32767);
}

TEST(Dicom, several_series_are_listed_and_one_is_picked) {
  const TempFolder folder;
  run_python(folder, write_series + R"(
series('all/a', uid='1.2.30.1', SeriesDescription='native', SeriesNumber=2)
series('all/b', uid='1.2.30.2', SeriesDescription='portal \x1b[2J venous', SeriesNumber=4, size=(6, 5, 7))
series('all/m', uid='1.2.30.3', Modality='MR')
series('all/s', uid='1.2.30.4', ImageType=['ORIGINAL', 'PRIMARY', 'LOCALIZER'], size=(6, 5, 1), SeriesDescription='scout')
)");
  const std::string all = test::message_of([&] { read_ct(folder / "all", silent); });
  EXPECT_NE(
      all.find("all: holds 2 CT series; pick one of 1: 4 slices, \"native\" (1.2.30.1); 2: 7 slices, \"portal ?[2J "
               "venous\" (1.2.30.2)"),
      std::string::npos)
      << all;
  for (const std::string wanted : {"2", "1.2.30.2"}) {
    const CtFile file = read_ct(folder / "all", silent, wanted);
    EXPECT_EQ(file.ct.grid.size[2], 7u);
    EXPECT_TRUE(has_note(file.notes, "left out, another series: 4 slices, \"native\""));
    EXPECT_TRUE(has_note(file.notes, "other modalities left out: MR"));
    EXPECT_TRUE(has_note(file.notes, "\"scout\""));
  }
  EXPECT_EQ(read_ct(folder / "all/b/slice003.dcm", silent).ct.grid.size[2], 7u);
  const auto message = [&](const std::string& wanted) {
    return test::message_of([&] { read_ct(folder / "all", silent, wanted); });
  };
  EXPECT_NE(message("1.2.30").find("several CT series \"1.2.30\""), std::string::npos);
  EXPECT_NE(message("9").find("no CT series \"9\"; pick one of 1: 4 slices"), std::string::npos) << message("9");
  EXPECT_NE(message("1.2.30.3").find("no CT series"), std::string::npos);
}

TEST(Dicom, scouts_and_copies_in_the_series_are_left_out) {
  const TempFolder folder;
  run_python(folder, write_series + R"(
def scout(ds, k):
    ds.SOPInstanceUID += '.9'
    ds.ImageType = ['ORIGINAL', 'PRIMARY', 'LOCALIZER']
series('ct')
series('ct', name=lambda k: f'scout{k}', size=(9, 8, 1), change=scout)
series('ct', name=lambda k: f'copy{k}', size=(6, 5, 2))
)");
  const CtFile file = read_ct(folder / "ct", silent);
  expect_in_place(file.ct, "with extras");
  EXPECT_EQ(file.ct.grid.size[2], 4u);
  EXPECT_TRUE(has_note(file.notes, "1 scout view left out"));
  EXPECT_TRUE(has_note(file.notes, "2 slices left out that came twice"));
}

}  // namespace
}  // namespace calot
