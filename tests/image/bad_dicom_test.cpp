// Everything wrong with a DICOM series is named: file and field.
#include <gtest/gtest.h>

#include "calot/image/ct_file.h"
#include "calot/image/dicom_files.h"
#include "tests/image/dicom_fixture.h"

namespace calot {
namespace {

using test::run_python;
using test::TempFolder;

class BadDicom : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    run_python(*folder_, test::write_series + R"(
def only(k_wanted, **tags):
    def change(ds, k):
        if k == k_wanted:
            for tag, value in tags.items():
                if value is None: delattr(ds, tag)
                else: setattr(ds, tag, value)
    return change
os.makedirs('nothing')
open('nothing/notes.txt', 'w').write('no images')
os.makedirs('empty')
series('mr', Modality='MR')
series('gap', size=(6, 5, 8))
os.remove('gap/slice004.dcm')
series('coronal_gap', size=(6, 5, 8), row=(1, 0, 0), column=(0, 0, -1))
os.remove('coronal_gap/slice002.dcm')
series('uneven', size=(6, 5, 8), change=only(4, ImagePositionPatient=[-10, -20, 30 + 12.4]))
def drift(ds, k):
    ds.ImagePositionPatient = [-10, -20, 30 + 3 * k + 0.05 * max(0, k - 30)]
series('drift', size=(3, 3, 60), change=drift)
series('same', change=only(2, ImagePositionPatient=[-10, -20, 33]))
series('size', change=only(2, Rows=3, Columns=10))
series('pixel', change=only(2, PixelSpacing=[2.0, 1.6]))
series('turned', change=only(1, ImageOrientationPatient=[1, 0, 0, 0, 0.98, 0.198997]))
def tilt(ds, k):
    ds.ImagePositionPatient = [-10, -20 - 3 * k * np.tan(np.radians(15)), 30 + 3 * k]
series('tilt', change=tilt)
series('one', size=(6, 5, 1))
series('no_position', change=only(1, ImagePositionPatient=None))
series('two_numbers', change=only(1, ImagePositionPatient=[1, 2]))
series('no_orientation', change=only(1, ImageOrientationPatient=None))
series('no_spacing', change=only(1, PixelSpacing=None))
series('zero_spacing', change=only(1, PixelSpacing=[0, 1]))
series('crooked', ImageOrientationPatient=[1, 0, 0, 0.5, 0.5, 0])
series('frames', change=only(3, NumberOfFrames=12))
series('inverse', change=only(1, PhotometricInterpretation='MONOCHROME1'))
def colour(ds, k):
    ds.SamplesPerPixel, ds.PhotometricInterpretation, ds.PlanarConfiguration = 3, 'RGB', 0
    ds.PixelData = bytes(3 * 30)
series('colour', bits=(8, 8, 0), change=colour)
series('packing', change=only(1, HighBit=14))
series('short', change=only(2, PixelData=bytes(20)))
series('flat', values=lambda p: np.full(p.shape[:-1], 40))
series('no_air', values=lambda p: np.abs(hu(p)))
series('no_tissue', values=lambda p: -np.abs(hu(p)) - 1)
series('cut_header')
bytes_ = open('cut_header/slice001.dcm', 'rb').read()
open('cut_header/slice001.dcm', 'wb').write(bytes_[:500])
series('cut_pixels', size=(64, 64, 3))
bytes_ = open('cut_pixels/slice001.dcm', 'rb').read()
open('cut_pixels/slice001.dcm', 'wb').write(bytes_[:-3000])
series('huge', size=(6, 5, 3), change=only(1, Rows=65535, Columns=65535))
series('j2k', size=(64, 64, 3), spacing=(0.3, 0.3))
open('plain.txt', 'w').write('hello')
)");
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string message(const std::string& name) {
    Progress silent;
    return test::message_of([&] { read_ct(*folder_ / name, silent); });
  }
  static void expect(const std::string& name, const std::string& where, const std::string& part) {
    const std::string text = message(name);
    EXPECT_TRUE(text.starts_with((*folder_ / where).string() + ": ")) << name << ": " << text;
    EXPECT_NE(text.find(part), std::string::npos) << name << ": " << text;
    EXPECT_NE(text.find("; "), std::string::npos) << "says what to do: " << text;
  }

  static std::optional<DicomSlice> read_header(const std::filesystem::path& path) {
    try {
      return read_dicom_header(path);
    } catch (const InputError&) {
      return {};
    }
  }

  static TempFolder* folder_;
};

TempFolder* BadDicom::folder_ = nullptr;

TEST_F(BadDicom, no_ct_there) {
  expect("nowhere", "nowhere", "no such file");
  expect("nothing", "nothing", "holds no DICOM images (1 file)");
  expect("empty", "empty", "holds no DICOM images (0 files)");
  expect("mr", "mr", "holds no CT: the field Modality says MR");
  expect("plain.txt", "plain.txt", "is no CT image that can be read");
}

TEST_F(BadDicom, slices_that_are_missing_or_out_of_place) {
  expect("gap", "gap",
         "slices are missing between z = 39 and 45 mm (ImagePositionPatient): spacing 6 mm where the others have 3 mm");
  expect("coronal_gap", "coronal_gap", "slices are missing between y = ");
  expect("uneven", "uneven", "the slice spacing is not the same everywhere: between z = 39 and 42.4 mm");
  expect("drift", "drift", "from where even spacing would put it");
  expect("same", "same", "two slices lie at the same place: slice001.dcm and slice002.dcm");
  expect("tilt", "tilt", "a gantry tilted by 15 degrees?");
  expect("one", "one", "has one slice only");
}

TEST_F(BadDicom, slices_that_differ) {
  expect("size", "size/slice002.dcm", "another size than slice000.dcm: 10 x 3 pixels (Columns, Rows) against 6 x 5");
  expect("pixel", "pixel/slice002.dcm", "another PixelSpacing than slice000.dcm: 1.6 mm against 1.5 mm");
  expect("turned", "turned/slice001.dcm", "another orientation (ImageOrientationPatient)");
}

TEST_F(BadDicom, fields_that_are_missing_or_wrong) {
  expect("no_position", "no_position/slice001.dcm", "no usable ImagePositionPatient");
  expect("two_numbers", "two_numbers/slice001.dcm", "no usable ImagePositionPatient");
  expect("no_orientation", "no_orientation/slice001.dcm", "no usable ImageOrientationPatient");
  expect("no_spacing", "no_spacing/slice001.dcm", "no usable PixelSpacing");
  expect("zero_spacing", "zero_spacing/slice001.dcm", "no usable PixelSpacing");
  expect("crooked", "crooked/slice000.dcm", "ImageOrientationPatient isn't two directions at right angles");
  expect("frames", "frames/slice003.dcm", "holds 12 frames (NumberOfFrames");
  expect("inverse", "inverse/slice001.dcm", "PhotometricInterpretation \"MONOCHROME1\"");
  expect("colour", "colour/slice000.dcm", "3 components, PhotometricInterpretation \"RGB\"");
  expect("packing", "packing/slice001.dcm", "HighBit 14");
}

TEST_F(BadDicom, values_that_are_no_hu) {
  expect("flat", "flat", "every voxel has the same value, 40");
  expect("no_air", "no_air", "are no HU");
  expect("no_tissue", "no_tissue", "are no HU");
}

TEST_F(BadDicom, truncated_and_damaged_files) {
  expect("short", "short/slice002.dcm", "");
  expect("cut_header", "cut_header/slice001.dcm",
         "ends within its header; copy or export the series again, or remove it if it isn't of this series");
  expect("cut_pixels", "cut_pixels/slice001.dcm", "");
  expect("huge", "huge/slice001.dcm", "another size");
  for (const std::string how : {"j2k", "jpeg", "rle", "jpegls"}) {
    std::filesystem::create_directory(*folder_ / ("cut_" + how));
    for (int k = 0; k < 3; ++k) {
      const std::string name = "/slice00" + std::to_string(k) + ".dcm";
      const auto result = test::run_command("cd '" + folder_->path().string() + "' && gdcmconv --" + how + " j2k" +
                                            name + " cut_" + how + name);
      ASSERT_EQ(result.status, 0) << result.output;
    }
    const auto victim = *folder_ / ("cut_" + how + "/slice001.dcm");
    const std::string bytes = test::read_bytes(victim);
    for (const double part : {0.5, 0.7, 0.9, 0.97}) {
      test::write_bytes(victim, bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size()))));
      expect("cut_" + how, "cut_" + how + "/slice001.dcm", "");
    }
  }
}

TEST_F(BadDicom, wrong_bytes_in_compressed_pixels_are_read_or_refused) {
  Progress silent;
  const auto source = *folder_ / "j2k/slice001.dcm";
  for (const std::string how : {"raw", "j2k", "jpeg", "rle", "jpegls"}) {
    const auto folder = *folder_ / ("flipped_" + how);
    std::filesystem::create_directory(folder);
    const auto result =
        test::run_command("gdcmconv --" + how + " '" + source.string() + "' '" + (folder / "a").string() + "'");
    ASSERT_EQ(result.status, 0) << result.output;
    const std::string good = test::read_bytes(folder / "a");
    for (std::size_t n = 0; n < 300; ++n) {
      std::string bytes = good;
      const std::size_t at = 132 + (n * 7919) % (bytes.size() - 132);
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << n % 8 | (n % 3 == 0 ? 0xf0 : 0)));
      test::write_bytes(folder / "a", bytes);
      EXPECT_FALSE(test::message_of([&] { read_ct(folder, silent); }).empty()) << "one slice is no volume";
      const auto slice = read_header(folder / "a");
      if (!slice || slice->rows != 64 || slice->columns != 64) continue;
      std::vector<std::int16_t> pixels(64 * 64);
      test::message_of([&] { read_dicom_pixels(*slice, pixels.data()); });
    }
  }
}

}  // namespace
}  // namespace calot
