// NIfTI label maps: round trips, and files that nibabel wrote and reads.
#include "calot/image/nifti.h"

#include <gtest/gtest.h>

#include "calot/base/files.h"
#include "calot/image/label_map.h"
#include "tests/support/files.h"
#include "tests/support/volumes.h"

namespace calot {
namespace {

using test::TempFolder;

using Vec3 = Eigen::Vector3d;

LabelMap landmarks(const VoxelGrid& grid) {
  LabelMap map = test::map_of(grid, [](int i, int j, int k) -> Label {
    if (i == 1 && j == 2 && k == 3) return 7;
    if (i == 4 && j == 0 && k == 1) return 300;
    return 0;
  });
  map.names = {{7, "first"}, {300, "second <&> \"last\""}};
  return map;
}

Vec3 place_of(const LabelMap& map, Label label) {
  for (std::size_t v = 0; v < map.voxels.size(); ++v)
    if (map.voxels[v] == label) {
      const auto& n = map.grid.size;
      return map.grid.to_world * Vec3(static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                                      static_cast<double>(v / (n[0] * n[1])));
    }
  ADD_FAILURE() << "no voxel has label " << label;
  return Vec3::Zero();
}

/// Runs a Python script with nibabel at hand, in a folder.
std::string run_nibabel(const TempFolder& folder, const std::string& script) {
  test::write_bytes(folder / "script.py", "import nibabel as nib, numpy as np\n" + script);
  const auto result = test::run_command("cd '" + folder.path().string() + "' && /usr/bin/python3 script.py");
  EXPECT_EQ(result.status, 0) << "needs the package python3-nibabel: " << result.output;
  return result.output;
}

TEST(Nifti, round_trips_an_oblique_volume_with_names) {
  const TempFolder folder;
  const LabelMap map = landmarks(test::oblique_grid({5, 6, 7}, {0.0005, 0.0007, 0.002}));
  for (const std::string name : {"a.nii", "a.nii.gz"}) {
    write_label_map(folder / name, map);
    const LabelMap back = read_label_map(folder / name);
    EXPECT_EQ(back.grid.size, map.grid.size);
    EXPECT_EQ(back.voxels, map.voxels);
    EXPECT_EQ(back.names, map.names);
    EXPECT_LT((back.grid.to_world.matrix() - map.grid.to_world.matrix()).cwiseAbs().maxCoeff(), 1e-8) << "as float mm";
  }
}

TEST(Nifti, the_same_map_gives_the_same_bytes) {
  const TempFolder folder;
  const LabelMap map = landmarks(test::oblique_grid({5, 6, 7}, {0.001, 0.001, 0.001}));
  write_label_map(folder / "a.nii.gz", map);
  write_label_map(folder / "b.nii.gz", map);
  EXPECT_EQ(test::read_bytes(folder / "a.nii.gz"), test::read_bytes(folder / "b.nii.gz"));
}

TEST(Nifti, landmarks_stay_in_place_in_every_orientation_and_type_that_nibabel_writes) {
  const TempFolder folder;
  run_nibabel(folder, R"(
from nibabel.orientations import axcodes2ornt, ornt_transform, io_orientation
c, s = np.cos(0.4), np.sin(0.4)
turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
affine = np.eye(4)
affine[:3, :3] = turn @ np.diag([0.7, 0.9, 3.0])
affine[:3, 3] = [-120.5, 33.25, 871.0]
data = np.zeros((6, 7, 8))
data[1, 2, 3], data[5, 0, 1], data[0, 6, 7] = 1, 2, 117
for name, matrix in (('straight', np.diag([0.7, 0.9, 3.0, 1.0])), ('oblique', affine)):
    base = nib.Nifti1Image(data.astype(np.int16), matrix)
    for codes in ('RAS', 'LPS', 'LAS', 'PIR', 'SAL', 'IPR'):
        start = io_orientation(matrix)
        image = base.as_reoriented(ornt_transform(start, axcodes2ornt(codes)))
        for kind in ('uint8', 'int16', 'uint16', 'int32', 'float32', 'float64', 'int64'):
            typed = nib.Nifti1Image(np.asarray(image.dataobj).astype(kind), image.affine, dtype=kind)
            nib.save(typed, f'{name}_{codes}_{kind}_s.nii.gz')
        typed.set_data_dtype(np.uint8)
        typed = nib.Nifti1Image(np.asarray(image.dataobj).astype(np.uint8), image.affine)
        typed.set_qform(image.affine, 1)
        typed.set_sform(None, 0)
        nib.save(typed, f'{name}_{codes}_uint8_q.nii')
)");
  Eigen::Affine3d oblique = Eigen::Affine3d::Identity();
  oblique.linear() =
      (Eigen::AngleAxisd(0.4, Vec3::UnitZ()) * Eigen::AngleAxisd(0.4, Vec3::UnitX())).toRotationMatrix() *
      Vec3(0.7e-3, 0.9e-3, 3e-3).asDiagonal();
  oblique.translation() = Vec3(-0.1205, 0.03325, 0.871);
  const Eigen::Affine3d straight(Eigen::Scaling(0.7e-3, 0.9e-3, 3e-3));
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    const std::string name = entry.path().filename().string();
    if (name.find(".nii") == std::string::npos) continue;
    ++files;
    const LabelMap map = read_label_map(entry.path());
    const Eigen::Affine3d& truth = name.starts_with("oblique") ? oblique : straight;
    EXPECT_LT((place_of(map, 1) - truth * Vec3(1, 2, 3)).norm(), 1e-6) << name;
    EXPECT_LT((place_of(map, 2) - truth * Vec3(5, 0, 1)).norm(), 1e-6) << name;
    EXPECT_LT((place_of(map, 117) - truth * Vec3(0, 6, 7)).norm(), 1e-6) << name;
    EXPECT_EQ(voxel_counts(map).size(), 3u) << name;
  }
  EXPECT_EQ(files, 2 * 6 * 8);
}

TEST(Nifti, reads_the_other_byte_order_and_other_units_and_scaled_values) {
  const TempFolder folder;
  run_nibabel(folder, R"(
data = np.zeros((4, 5, 6), np.int16)
data[3, 1, 2] = 9
affine = np.diag([2.0, 2.0, 2.0, 1.0])
big = nib.Nifti1Image(data.astype('>i2'), affine, nib.Nifti1Header(endianness='>'))
nib.save(big, 'big.nii.gz')
metres = nib.Nifti1Image(data, np.diag([0.002, 0.002, 0.002, 1.0]))
metres.header.set_xyzt_units('meter')
nib.save(metres, 'metres.nii.gz')
microns = nib.Nifti1Image(data, np.diag([2000.0, 2000.0, 2000.0, 1.0]))
microns.header.set_xyzt_units('micron')
nib.save(microns, 'microns.nii.gz')
scaled = nib.Nifti1Image(data, affine)
scaled.header.set_slope_inter(1, 0)
nib.save(scaled, 'plain.nii')
four = nib.Nifti1Image(data[..., None], affine)
nib.save(four, 'four.nii.gz')
)");
  for (const std::string name : {"big.nii.gz", "metres.nii.gz", "microns.nii.gz", "plain.nii", "four.nii.gz"}) {
    const LabelMap map = read_label_map(folder / name);
    EXPECT_LT((place_of(map, 9) - Vec3(0.006, 0.002, 0.004)).norm(), 1e-7) << name;
  }
}

TEST(Nifti, reads_names_as_totalsegmentator_writes_them) {
  const TempFolder folder;
  run_nibabel(folder, R"(
data = np.zeros((3, 3, 3), np.uint8)
data[1, 1, 1] = 4
xml = '<?xml version="1.0" encoding="UTF-8"?> <CaretExtension>  <Date><![CDATA[2013-07-14T05:45:09]]></Date>   ' \
      '<VolumeInformation Index="0">   <LabelTable>\n' \
      '<Label Key="4" Red="1.0" Green="0.0" Blue="1.0" Alpha="1"><![CDATA[gallbladder]]></Label>\n' \
      '<Label Key="5" Red="0.0" Green="1.0" Blue="1.0" Alpha="1"><![CDATA[liver]]></Label>\n' \
      '  </LabelTable>  <StudyMetaDataLinkSet>  </StudyMetaDataLinkSet>  <VolumeType><![CDATA[Label]]></VolumeType>   ' \
      '</VolumeInformation></CaretExtension>'
image = nib.Nifti1Image(data, np.eye(4))
image.header.extensions.append(nib.nifti1.Nifti1Extension(6, b'a comment that comes first'))
image.header.extensions.append(nib.nifti1.Nifti1Extension(0, bytes(xml, 'utf-8')))
nib.save(image, 'named.nii.gz')
)");
  const LabelMap map = read_label_map(folder / "named.nii.gz");
  EXPECT_EQ(map.names, (std::map<Label, std::string>{{4, "gallbladder"}, {5, "liver"}}));
  EXPECT_EQ(label_matching(map, "gallbladder", "x"), 4);
  EXPECT_EQ(label_matching(map, "4", "x"), 4);
  const std::string message = test::message_of([&] { label_matching(map, "spleen", "--labels"); });
  EXPECT_NE(message.find("4 (gallbladder)"), std::string::npos) << message;
}

TEST(Nifti, nibabel_reads_what_we_write) {
  const TempFolder folder;
  const LabelMap map = landmarks(test::oblique_grid({5, 6, 7}, {0.001, 0.002, 0.003}));
  write_label_map(folder / "ours.nii.gz", map);
  CtImage ct{map.grid, std::vector<std::int16_t>(map.grid.count(), -75)};
  ct.hounsfield[map.grid.index(4, 5, 6)] = 1200;
  write_ct(folder / "ct.nii.gz", ct);
  const std::string output = run_nibabel(folder, R"(
image = nib.load('ours.nii.gz')
data = np.asarray(image.dataobj)
assert data.shape == (5, 6, 7) and data[1, 2, 3] == 7 and data[4, 0, 1] == 300 and (data > 0).sum() == 2
assert np.allclose(image.get_sform(), image.get_qform(), atol=1e-4)
assert image.header.get_xyzt_units()[0] == 'mm'
extension, = image.header.extensions
assert extension.get_code() == 30
import xml.etree.ElementTree as tree
print([(l.get('Key'), l.text) for l in tree.fromstring(extension.get_content().rstrip(b'\0')).iter('Label')])
print(*(image.affine @ [1, 2, 3, 1])[:3])
ct = np.asarray(nib.load('ct.nii.gz').dataobj)
assert ct.dtype == np.int16 and ct[4, 5, 6] == 1200 and ct[0, 0, 0] == -75
)");
  EXPECT_NE(output.find("('7', 'first'), ('300', 'second <&> \"last\"')"), std::string::npos) << output;
  const Vec3 place = 1e3 * (map.grid.to_world * Vec3(1, 2, 3));
  Vec3 theirs;
  ASSERT_EQ(std::sscanf(output.substr(output.find('\n')).c_str(), "%lf %lf %lf", &theirs[0], &theirs[1], &theirs[2]),
            3);
  EXPECT_LT((theirs - place).norm(), 1e-4);
}

}  // namespace
}  // namespace calot
