// DICOM series that pydicom writes for the tests, an independent hand.
#pragma once
#include <string>

#include "tests/support/files.h"

namespace calot::test {

/// Python: series(folder, …) writes one file a slice. A voxel's HU is hu(place), a function of its place in LPS
/// millimetres, so that a voxel that is in the wrong place has the wrong value.
inline const std::string write_series = R"(
import os, random, numpy as np, pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian, ImplicitVRLittleEndian, ExplicitVRBigEndian

def hu(place):
    x, y, z = place[..., 0], place[..., 1], place[..., 2]
    return np.rint(400 * np.sin(0.9 * x + 0.3) + 300 * np.cos(0.7 * y) + 250 * np.sin(0.8 * z) - 50).astype(int)

def series(folder, *, size=(6, 5, 4), row=(1, 0, 0), column=(0, 1, 0), origin=(-10.0, -20.0, 30.0), spacing=(2.0, 1.5),
           step=3.0, uid='1.2.826.0.1.3680043.9.1', name=lambda k: f'slice{k:03}.dcm', change=lambda ds, k: None,
           syntax=ExplicitVRLittleEndian, bits=(16, 16, 1), shift=(1, 0), after=lambda ds, k: None, values=hu, **tags):
    os.makedirs(folder, exist_ok=True)
    row, column, origin = (np.array(v, float) for v in (row, column, origin))
    normal = np.cross(row, column)
    columns, rows, slices = size
    for k in range(slices):
        corner = origin + k * step * normal
        i, j = np.meshgrid(np.arange(columns), np.arange(rows))
        places = corner + i[..., None] * spacing[1] * row + j[..., None] * spacing[0] * column
        slope, intercept = shift
        stored = np.rint((values(places) - intercept) / slope).astype(int)
        ds = Dataset()
        ds.SOPClassUID = '1.2.840.10008.5.1.4.1.1.2'
        ds.SOPInstanceUID = f'{uid}.{k + 1}'
        ds.SeriesInstanceUID, ds.StudyInstanceUID = uid, uid + '.0'
        ds.Modality, ds.SeriesDescription, ds.SeriesNumber = 'CT', 'abdomen', 3
        ds.ImageType = ['ORIGINAL', 'PRIMARY', 'AXIAL']
        ds.Rows, ds.Columns, ds.SamplesPerPixel, ds.PhotometricInterpretation = rows, columns, 1, 'MONOCHROME2'
        ds.PixelSpacing = [repr(float(s)) for s in spacing]
        ds.ImagePositionPatient = [f'{v:.8f}'[:16] for v in corner]
        ds.ImageOrientationPatient = [f'{v:.12f}'[:16] for v in (*row, *column)]
        ds.RescaleSlope, ds.RescaleIntercept, ds.RescaleType = slope, intercept, 'HU'
        ds.BitsAllocated, ds.BitsStored, ds.PixelRepresentation = bits
        ds.HighBit = bits[1] - 1
        ds.InstanceNumber = slices - k
        for tag, value in tags.items():
            setattr(ds, tag, value)
        kind = {8: 'u1', 16: 'u2', 32: 'u4'}[bits[0]]
        order = '>' if syntax == ExplicitVRBigEndian else '<'
        ds.PixelData = (stored & ((1 << bits[1]) - 1)).astype(order + kind).tobytes()
        if len(ds.PixelData) % 2:
            ds.PixelData += b'\0'
        ds['PixelData'].VR = 'OB' if bits[0] == 8 else 'OW'
        change(ds, k)
        ds.file_meta = FileMetaDataset()
        ds.file_meta.TransferSyntaxUID = syntax
        ds.file_meta.MediaStorageSOPClassUID = ds.SOPClassUID
        ds.file_meta.MediaStorageSOPInstanceUID = ds.SOPInstanceUID
        ds.is_little_endian = syntax != ExplicitVRBigEndian
        ds.is_implicit_VR = syntax == ImplicitVRLittleEndian
        ds.save_as(os.path.join(folder, name(k)), write_like_original=False)
)";

inline void run_python(const TempFolder& folder, const std::string& script) {
  write_bytes(folder / "script.py", script);
  const auto result = run_command("cd '" + folder.path().string() + "' && /usr/bin/python3 script.py");
  if (result.status != 0) throw std::runtime_error("needs python3-pydicom and python3-nibabel: " + result.output);
}

}  // namespace calot::test
