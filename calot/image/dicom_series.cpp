#include "calot/image/dicom_series.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "calot/base/error.h"
#include "calot/image/text.h"

namespace calot {
namespace fs = std::filesystem;
namespace {

using Vec3 = Eigen::Vector3d;

constexpr std::size_t most_files = 200000;
constexpr std::size_t largest_count = std::size_t{1} << 31;  // of voxels, as for NIfTI

template <class Iterator>
std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code code;
  Iterator it(folder, code), end;
  for (; !code && it != end; it.increment(code)) {
    if (it->path().filename().string().starts_with('.') || !it->is_regular_file(code)) continue;
    files.push_back(it->path());
    if (files.size() > most_files)
      throw InputError(folder.string(), "holds more than " + std::to_string(most_files) + " files",
                       "name the folder of one study");
  }
  if (code) throw InputError(folder.string(), "can't be listed: " + code.message(), "check its permissions");
  std::sort(files.begin(), files.end());
  return files;
}

std::string described(const DicomSeries& series) {
  return count_of(series.slices.size(), "slice") + ", " + in_quotes(series.description) + " (" + series.uid + ")";
}

std::string list_of(const std::vector<DicomSeries>& all) {
  std::string text;
  for (std::size_t s = 0; s < std::min<std::size_t>(all.size(), 20); ++s)
    text += (s ? "; " : "") + std::to_string(s + 1) + ": " + described(all[s]);
  return all.size() > 20 ? text + " and " + std::to_string(all.size() - 20) + " more" : text;
}

bool is_volume_slice(const DicomSlice& slice) {
  return !slice.position.empty() && !slice.localizer && slice.photometric == "MONOCHROME2";
}

/// CT series with at least one slice that could be part of a volume; all CT series where there is none such.
std::vector<DicomSeries> ct_series(std::vector<DicomSeries>& all, const std::string& where,
                                   std::vector<std::string>& notes) {
  std::vector<DicomSeries> ct, flat;
  std::set<std::string> other;
  for (DicomSeries& series : all) {
    if (series.modality != "CT") {
      other.insert(series.modality.empty() ? "none" : series.modality);
      continue;
    }
    const bool volume = std::any_of(series.slices.begin(), series.slices.end(), is_volume_slice);
    (volume ? ct : flat).push_back(std::move(series));
  }
  std::string names;
  for (const std::string& name : other) names += (names.empty() ? "" : ", ") + plain_text(name);
  if (ct.empty() && flat.empty())
    throw InputError(where, "holds no CT: the field Modality says " + names, "name the folder of a CT series");
  if (!other.empty()) notes.push_back("series of other modalities left out: " + names);
  if (ct.empty()) return flat;
  for (const DicomSeries& series : flat) notes.push_back("left out, no slices of a volume: " + described(series));
  return ct;
}

std::size_t index_of(const std::vector<DicomSeries>& ct, const std::string& where, const std::string& wanted) {
  const std::string advice = "pick one of " + list_of(ct);
  if (wanted.empty() && ct.size() == 1) return 0;
  if (wanted.empty()) throw InputError(where, "holds " + std::to_string(ct.size()) + " CT series", advice);
  if (wanted.size() < 4 && wanted.find_first_not_of("0123456789") == std::string::npos) {
    const auto number = static_cast<std::size_t>(std::stoul(wanted));
    if (number >= 1 && number <= ct.size()) return number - 1;
  }
  std::vector<std::size_t> found;
  for (std::size_t s = 0; s < ct.size(); ++s) {
    if (ct[s].uid == wanted) return s;
    if (ct[s].uid.starts_with(wanted)) found.push_back(s);
  }
  if (found.size() == 1) return found[0];
  throw InputError(where, (found.empty() ? "has no CT series " : "has several CT series ") + in_quotes(wanted), advice);
}

// ---- the slices of one series

[[noreturn]] void bad_slice(const DicomSlice& slice, const std::string& what, const std::string& advice) {
  throw InputError(slice.path.string(), what, advice);
}

/// Scout views and files that are there twice go.
void drop_extra_slices(DicomSeries& series, std::vector<std::string>& notes) {
  std::set<std::string> seen;
  std::size_t scouts = 0, copies = 0;
  std::vector<DicomSlice> kept;
  const bool only_scouts =
      std::all_of(series.slices.begin(), series.slices.end(), [](const DicomSlice& s) { return s.localizer; });
  for (DicomSlice& slice : series.slices) {
    if (slice.localizer && !only_scouts)
      ++scouts;
    else if (!slice.instance_uid.empty() && !seen.insert(slice.instance_uid).second)
      ++copies;
    else
      kept.push_back(std::move(slice));
  }
  series.slices = std::move(kept);
  if (scouts) notes.push_back(count_of(scouts, "scout view") + " left out");
  if (copies) notes.push_back(count_of(copies, "slice") + " left out that came twice (same SOPInstanceUID)");
}

void check_slice(const DicomSlice& slice) {
  const std::string again = "export the series again";
  if (slice.frames != 1)
    bad_slice(slice, "holds " + std::to_string(slice.frames) + " frames (NumberOfFrames: an enhanced CT)",
              "convert it to one file a slice, or to NIfTI");
  if (slice.samples != 1 || slice.photometric != "MONOCHROME2")
    bad_slice(slice,
              "has pixels of " + std::to_string(slice.samples) + " components, PhotometricInterpretation " +
                  in_quotes(slice.photometric) + ", not HU",
              "give a CT series");
  if (slice.position.size() != 3) bad_slice(slice, "has no usable ImagePositionPatient", again);
  if (slice.orientation.size() != 6) bad_slice(slice, "has no usable ImageOrientationPatient", again);
  if (slice.spacing.size() != 2 || !(slice.spacing[0] > 0 && slice.spacing[1] > 0))
    bad_slice(slice, "has no usable PixelSpacing", again);
  const Eigen::Map<const Vec3> row(slice.orientation.data()), column(slice.orientation.data() + 3);
  if (std::abs(row.norm() - 1) > 1e-3 || std::abs(column.norm() - 1) > 1e-3 || std::abs(row.dot(column)) > 1e-3)
    bad_slice(slice, "its ImageOrientationPatient isn't two directions at right angles", again);
}

void check_alike(const DicomSlice& a, const DicomSlice& b) {
  const std::string against = " than " + a.path.filename().string(), advice = "give the slices of one scan only";
  if (a.rows != b.rows || a.columns != b.columns)
    bad_slice(b,
              "has another size" + against + ": " + std::to_string(b.columns) + " x " + std::to_string(b.rows) +
                  " pixels (Columns, Rows) against " + std::to_string(a.columns) + " x " + std::to_string(a.rows),
              advice);
  for (std::size_t d = 0; d < 2; ++d)
    if (std::abs(a.spacing[d] - b.spacing[d]) > 1e-3 * a.spacing[d])
      bad_slice(b,
                "has another PixelSpacing" + against + ": " + short_number(b.spacing[d]) + " mm against " +
                    short_number(a.spacing[d]) + " mm",
                advice);
  for (std::size_t d = 0; d < 6; ++d)
    if (std::abs(a.orientation[d] - b.orientation[d]) > 1e-3)
      bad_slice(b, "has another orientation (ImageOrientationPatient)" + against, advice);
}

/// Where the slices lie: along their normal, and how to say it to people.
struct Stack {
  Vec3 row, column, normal;
  std::vector<double> along;  // of each slice, ascending
  Eigen::Index axis = 2;      // that the normal follows most

  [[nodiscard]] std::string place(const DicomSlice& slice) const {
    return short_number(slice.position[static_cast<std::size_t>(axis)]);
  }
  [[nodiscard]] std::string between(const DicomSlice& a, const DicomSlice& b) const {
    return std::string("between ") + "xyz"[axis] + " = " + place(a) + " and " + place(b) + " mm (ImagePositionPatient)";
  }
};

Vec3 position_of(const DicomSlice& slice) {
  return {slice.position[0], slice.position[1], slice.position[2]};
}

Stack stack_slices(std::vector<DicomSlice>& slices) {
  const std::vector<double>& o = slices[0].orientation;
  Stack stack;
  stack.row = Vec3(o[0], o[1], o[2]).normalized();
  stack.column = Vec3(o[3], o[4], o[5]).normalized();
  stack.normal = stack.row.cross(stack.column).normalized();
  stack.normal.cwiseAbs().maxCoeff(&stack.axis);
  const auto along = [&](const DicomSlice& slice) { return stack.normal.dot(position_of(slice)); };
  std::stable_sort(slices.begin(), slices.end(),
                   [&](const DicomSlice& a, const DicomSlice& b) { return along(a) < along(b); });
  for (const DicomSlice& slice : slices) stack.along.push_back(along(slice));
  return stack;
}

double median_gap(const std::vector<double>& along) {
  std::vector<double> gaps;
  for (std::size_t s = 1; s < along.size(); ++s) gaps.push_back(along[s] - along[s - 1]);
  std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
  return gaps[gaps.size() / 2];
}

/// @return the spacing of the slices [mm]
double check_spacing(const std::vector<DicomSlice>& slices, const Stack& stack, const std::string& where) {
  const std::size_t n = slices.size();
  const double usual = median_gap(stack.along), allowed = std::max(0.02 * usual, 0.05);
  for (std::size_t s = 1; s < n; ++s) {
    const double gap = stack.along[s] - stack.along[s - 1];
    if (gap < 0.01)
      throw InputError(where,
                       "two slices lie at the same place: " + slices[s - 1].path.filename().string() + " and " +
                           slices[s].path.filename().string() + ", ImagePositionPatient " + "xyz"[stack.axis] + " = " +
                           stack.place(slices[s]) + " mm",
                       "give the slices of one scan only (several phases in one series?)");
    if (std::abs(gap - usual) <= allowed) continue;
    const std::string spacing =
        ": spacing " + short_number(gap) + " mm where the others have " + short_number(usual) + " mm";
    if (gap > 1.5 * usual)
      throw InputError(where, "slices are missing " + stack.between(slices[s - 1], slices[s]) + spacing,
                       "copy or export the whole series");
    throw InputError(
        where, "the slice spacing is not the same everywhere: " + stack.between(slices[s - 1], slices[s]) + spacing,
        "resample the series, or give one with even spacing");
  }
  const double mean = (stack.along.back() - stack.along.front()) / static_cast<double>(n - 1);
  for (std::size_t s = 0; s < n; ++s) {
    const double off = stack.along[s] - stack.along[0] - static_cast<double>(s) * mean;
    if (std::abs(off) > 0.1 * mean + 0.05)
      throw InputError(where,
                       "the slice spacing is not the same everywhere: " + slices[s].path.filename().string() +
                           " lies " + short_number(off) + " mm from where even spacing would put it",
                       "resample the series, or give one with even spacing");
  }
  return mean;
}

void check_shear(const std::vector<DicomSlice>& slices, const Stack& stack, const std::string& where) {
  for (std::size_t s = 1; s < slices.size(); ++s) {
    const Vec3 moved = position_of(slices[s]) - position_of(slices[0]);
    const double along = stack.along[s] - stack.along[0], sideways = (moved - along * stack.normal).norm();
    if (sideways <= 0.05 + 1e-3 * along) continue;
    const Vec3 whole = position_of(slices.back()) - position_of(slices[0]);
    const double far = stack.along.back() - stack.along[0], shift = (whole - far * stack.normal).norm();
    throw InputError(where,
                     "its slices are sheared: over " + short_number(far) + " mm they move " + short_number(shift) +
                         " mm sideways (ImagePositionPatient; a gantry tilted by " +
                         short_number(std::atan2(shift, far) * 180 / M_PI) + " degrees?)",
                     "resample it onto a rectangular grid");
  }
}

}  // namespace

std::vector<DicomSeries> find_series(const fs::path& folder, bool deep, Progress& progress,
                                     std::vector<std::string>& notes) {
  progress.phase("reading DICOM headers");
  const std::vector<fs::path> files =
      deep ? files_in<fs::recursive_directory_iterator>(folder) : files_in<fs::directory_iterator>(folder);
  std::map<std::string, DicomSeries> by_uid;
  std::size_t passed = 0;
  std::string example;
  for (std::size_t f = 0; f < files.size(); ++f) {
    progress.at(static_cast<double>(f) / static_cast<double>(files.size()));
    auto slice = read_dicom_header(files[f]);
    if (!slice) {
      if (passed++ == 0) example = files[f].filename().string();
      continue;
    }
    // One series with images of two kinds of machine is two for us.
    DicomSeries& series = by_uid[slice->series_uid + ' ' + slice->modality];
    if (series.slices.empty())
      series = {slice->series_uid, slice->description, slice->modality, slice->series_number, {}};
    series.slices.push_back(std::move(*slice));
  }
  if (by_uid.empty())
    throw InputError(folder.string(), "holds no DICOM images (" + count_of(files.size(), "file") + ")",
                     "name the folder of a CT series, or a .nii.gz or .nrrd file");
  if (passed) notes.push_back(count_of(passed, "file") + " passed over that are no DICOM images, e.g. " + example);
  std::vector<DicomSeries> all;
  all.reserve(by_uid.size());
  for (auto& [uid, series] : by_uid) all.push_back(std::move(series));
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  return all;
}

DicomSeries choose_series(std::vector<DicomSeries> all, const std::string& where, const std::string& wanted,
                          std::vector<std::string>& notes) {
  std::vector<DicomSeries> ct = ct_series(all, where, notes);
  const std::size_t chosen = index_of(ct, where, wanted);
  for (std::size_t s = 0; s < ct.size(); ++s)
    notes.push_back((s == chosen ? "read: " : "left out, another series: ") + described(ct[s]));
  return std::move(ct[chosen]);
}

VoxelGrid order_slices(DicomSeries& series, const std::string& where, std::vector<std::string>& notes) {
  drop_extra_slices(series, notes);
  std::vector<DicomSlice>& slices = series.slices;
  for (const DicomSlice& slice : slices) check_slice(slice);
  for (const DicomSlice& slice : slices) check_alike(slices[0], slice);
  if (slices.size() < 2) throw InputError(where, "has one slice only", "give the whole series");
  const DicomSlice& first = slices[0];
  const Eigen::Vector2d in_plane(first.spacing[1], first.spacing[0]);
  VoxelGrid grid;
  grid.size = {static_cast<std::size_t>(first.columns), static_cast<std::size_t>(first.rows), slices.size()};
  if (grid.count() > largest_count) throw InputError(where, "has more than 2^31 voxels", "crop or resample it");
  const Stack stack = stack_slices(slices);
  const double spacing = check_spacing(slices, stack, where);
  check_shear(slices, stack, where);
  const Vec3 to_ras = 1e-3 * Vec3(-1, -1, 1);  // from LPS [mm]
  grid.to_world.linear().col(0) = in_plane[0] * to_ras.cwiseProduct(stack.row);
  grid.to_world.linear().col(1) = in_plane[1] * to_ras.cwiseProduct(stack.column);
  grid.to_world.linear().col(2) = spacing * to_ras.cwiseProduct(stack.normal);
  grid.to_world.translation() = to_ras.cwiseProduct(position_of(slices[0]));
  check_axes(grid.to_world, where);
  if (std::any_of(slices.begin(), slices.end(), [](const auto& s) { return s.slope.empty() || s.intercept.empty(); }))
    notes.push_back("slices without RescaleSlope or RescaleIntercept: their numbers are taken as HU");
  return grid;
}

}  // namespace calot
