#include "calot/patient/abdominal_wall.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "calot/base/parallel.h"
#include "calot/patient/body_scan.h"

namespace calot {
namespace {

using detail::BodyScan;

constexpr double mm = 1e-3;
constexpr double muscle = 10 * mm;             // behind the fat under the skin: muscle and peritoneum
constexpr double usual_thickness = 25 * mm;    // of the wall
constexpr double usual_half_width = 140 * mm;  // of an adult's cavity
constexpr double usual_flatness = 0.62;        // depth of the front over half the width
constexpr double duct_from_midline = 30 * mm;  // the bile duct lies to the right of it
constexpr double lift = 40 * mm;               // at the umbilicus, 12 to 15 mmHg
constexpr double dome_reach = 185 * mm;        // of the dome above and below the umbilicus
constexpr double clearance = 3 * mm;           // between an organ and the wall at rest
constexpr float none = std::numeric_limits<float>::quiet_NaN();

double part_of(std::vector<double> values, double part) {
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

std::string text(const char* format, double value) {
  std::array<char, 240> line{};
  std::snprintf(line.data(), line.size(), format, value);
  return line.data();
}

}  // namespace

AbdominalWall::AbdominalWall(const CompletedAnatomy& anatomy, const Vec3& bile_duct, std::vector<std::string>& notes) {
  const BodyScan scan(anatomy);
  middle_z_ = umbilicus_z_ = bile_duct[2];
  find_midline(scan, bile_duct, notes);
  find_skin(scan);
  std::vector<std::string> of_front;
  find_thickness(scan, of_front);
  fit_front(of_front);
  notes.insert(notes.end(), of_front.begin(), of_front.end());
  spread_correction();
}

/// The vertebral column, where the field holds it; else the body's sides; else the usual distance from the bile duct.
void AbdominalWall::find_midline(const BodyScan& scan, const Vec3& bile_duct, std::vector<std::string>& notes) {
  const BodyScan::Sides sides = scan.sides();
  const std::optional<double> spine = scan.spine(bile_duct);
  if (spine || sides.middle) {
    midline_ = spine ? *spine : *sides.middle;
  } else {
    midline_ = bile_duct[0] - duct_from_midline;
    notes.push_back(text(
        "the CT holds neither the vertebral column nor both sides of the body: the midline is assumed %.0f mm to the "
        "left of the bile duct",
        duct_from_midline / mm));
  }
  half_width_ = usual_half_width;
  if (sides.half_width)
    half_width_ = *sides.half_width - usual_thickness;
  else if (sides.right)
    half_width_ = *sides.right - usual_thickness - midline_;
  else
    notes.push_back(
        text("the CT doesn't hold the body's sides: the cavity is assumed %.0f mm wide", 2 * half_width_ / mm));
  half_width_ = std::max(half_width_, scan.organs_right() - midline_ + clearance);
}

/// From the front: the first body cell behind air, and the first organ.
void AbdominalWall::find_skin(const BodyScan& scan) {
  constexpr auto stride = static_cast<std::size_t>(column_size / BodyScan::cell + 0.5);
  size_ = {(scan.size[0] + stride - 1) / stride, (scan.size[2] + stride - 1) / stride};
  origin_ = {scan.origin[0], scan.origin[2]};
  skin_.assign(size_[0] * size_[1], none);
  organ_front_.assign(skin_.size(), none);
  for (std::size_t c = 0; c < skin_.size(); ++c) {
    const std::size_t i = c % size_[0] * stride, k = c / size_[0] * stride;
    bool air = false, found = false;
    for (std::size_t j = scan.size[1]; j-- > 0;) {
      const std::size_t cell = scan.index(i, j, k);
      if (scan.organ[cell] != 0) {
        organ_front_[c] = static_cast<float>(scan.at(1, j));
        break;
      }
      if (found || scan.kind[cell] == BodyScan::outside_field) continue;
      if (scan.kind[cell] == BodyScan::air) air = true;
      if (scan.kind[cell] != BodyScan::body) continue;
      if (air) skin_[c] = static_cast<float>(scan.at(1, j));
      found = true;
    }
  }
}

/// Skin and the fat under it as the columns near the midline see them, and an assumed muscle behind.
void AbdominalWall::find_thickness(const BodyScan& scan, std::vector<std::string>& notes) {
  constexpr auto stride = static_cast<std::size_t>(column_size / BodyScan::cell + 0.5);
  std::vector<double> depths;
  for (std::size_t c = 0; c < skin_.size(); ++c) {
    if (!(skin_[c] == skin_[c]) || std::abs(x_of(c) - midline_) > 0.9 * half_width_) continue;
    const std::size_t i = c % size_[0] * stride, k = c / size_[0] * stride;
    const auto first = static_cast<std::size_t>((skin_[c] - scan.origin[1]) / BodyScan::cell + 0.5);
    int firm = 0;  // cells of muscle in a row
    bool fat = false;
    for (std::size_t j = first + 1; j-- > 0 && first - j < 40;) {
      const double hu = scan.hounsfield[scan.index(i, j, k)];
      fat = fat || hu < -40;
      firm = fat && hu > -20 ? firm + 1 : 0;
      if (firm < 2) continue;
      depths.push_back(static_cast<double>(first - j - 1) * BodyScan::cell / steepness(x_of(c)) + muscle);
      break;
    }
  }
  const auto seen = std::count_if(skin_.begin(), skin_.end(), [](float y) { return y == y; });
  skin_seen_ = seen >= 60;  // about 10 cm²
  thickness_ = usual_thickness;
  if (!skin_seen_) return;
  if (depths.size() >= 20 && 3 * std::ssize(depths) > seen) {
    thickness_ = std::clamp(part_of(depths, 0.5), 12 * mm, 90 * mm);
    notes.push_back(text("the abdominal wall is %.0f mm thick", thickness_ / mm) +
                    text(": skin and fat as the CT shows them, and %.0f mm of muscle assumed", muscle / mm));
  } else
    notes.push_back(
        text("the layers of the abdominal wall can't be told apart in the CT: it is assumed to be %.0f mm "
             "thick",
             thickness_ / mm));
}

/// How much longer the wall is along y than across itself, on a usual front.
double AbdominalWall::steepness(double x) const {
  const double u = std::min(0.95, std::abs(x - midline_) / half_width_);
  return std::hypot(1.0, usual_flatness * u / std::sqrt(1 - u * u));
}

double AbdominalWall::inner_y(std::size_t c) const {
  return skin_[c] - thickness_ * steepness(x_of(c));
}

double AbdominalWall::bulge_at(double x) const {
  const double u = (x - midline_) / half_width_;
  return std::sqrt(std::max(0.0, 1 - u * u));
}

double AbdominalWall::model_y(double x, double z) const {
  return front_ + bulge_ * bulge_at(x) + slope_ * (z - middle_z_);
}

void AbdominalWall::fit_front(std::vector<std::string>& notes) {
  if (skin_seen_) fit_to_skin();
  if (skin_seen_ && !(bulge_ > 0.3 * half_width_ && bulge_ < 1.2 * half_width_)) {
    skin_seen_ = false;  // what looked like skin is none: gas in a bowel at the field's border
    notes.clear();
  }
  if (skin_seen_) return;
  fit_to_organs();
  notes.push_back(
      text("the skin isn't in the CT: the abdominal wall is assumed %.0f mm in front of the organs", clearance / mm));
}

/// Least squares, leaving out what lies far off (cables, gas): beyond 4.5 median deviations. Where only a flank is
/// seen, a usual front decides between the many that fit.
void AbdominalWall::fit_to_skin() {
  std::vector<std::size_t> columns;
  double mean_z = 0;
  for (std::size_t c = 0; c < skin_.size(); ++c)
    if (skin_[c] == skin_[c] && std::abs(x_of(c) - midline_) < 0.9 * half_width_) columns.push_back(c);
  for (const std::size_t c : columns) mean_z += z_of(c) / static_cast<double>(columns.size());
  middle_z_ = mean_z;
  for (int round = 0; round < 4 && columns.size() >= 20; ++round) {
    constexpr double usual = 30;  // columns that the usual front counts for
    Eigen::Matrix3d normal = Vec3(1e-9, usual, usual * 50 * mm * 50 * mm).asDiagonal();
    Vec3 right(0, usual * usual_flatness * half_width_, 0);
    for (const std::size_t c : columns) {
      const Vec3 row(1, bulge_at(x_of(c)), z_of(c) - middle_z_);
      normal += row * row.transpose();
      right += row * inner_y(c);
    }
    const Vec3 found = normal.ldlt().solve(right);
    front_ = found[0], bulge_ = found[1], slope_ = std::clamp(found[2], -0.5, 0.5);
    const auto off = [&](std::size_t c) { return std::abs(inner_y(c) - model_y(x_of(c), z_of(c))); };
    std::vector<double> deviations;
    for (const std::size_t c : columns) deviations.push_back(off(c));
    const double limit = std::max(5 * mm, 4.5 * part_of(deviations, 0.5));
    std::erase_if(columns, [&](std::size_t c) { return off(c) > limit; });
  }
  for (std::size_t c = 0; c < skin_.size(); ++c)
    if (std::abs(inner_y(c) - model_y(x_of(c), z_of(c))) > 25 * mm) skin_[c] = none;
}

/// A usual front, just before all organs.
void AbdominalWall::fit_to_organs() {
  bulge_ = usual_flatness * half_width_;
  slope_ = 0;
  std::vector<double> fronts;
  for (std::size_t c = 0; c < organ_front_.size(); ++c) {
    skin_[c] = none;
    if (organ_front_[c] == organ_front_[c] && std::abs(x_of(c) - midline_) < 0.9 * half_width_)
      fronts.push_back(organ_front_[c] - bulge_ * bulge_at(x_of(c)));
  }
  front_ = (fronts.empty() ? 0 : part_of(fronts, 0.98)) + clearance;
}

/// What the skin says beyond the model, smoothed over about 15 mm and fading out over 60 mm where it isn't seen; and
/// no organ in the wall.
void AbdominalWall::spread_correction() {
  constexpr int reach = 16;  // columns
  correction_.assign(skin_.size(), 0);
  parallel_for(size_[1], [&](std::size_t k) {
    for (std::size_t i = 0; i < size_[0]; ++i) {
      double sum = 0, weight = 0.02, organ = -1e9;
      for (int dk = -reach; dk <= reach; ++dk)
        for (int di = -reach; di <= reach; ++di) {
          const auto a = static_cast<std::ptrdiff_t>(i) + di, b = static_cast<std::ptrdiff_t>(k) + dk;
          if (a < 0 || b < 0 || a >= std::ssize(skin_) || a >= static_cast<std::ptrdiff_t>(size_[0]) ||
              b >= static_cast<std::ptrdiff_t>(size_[1]))
            continue;
          const std::size_t c = static_cast<std::size_t>(a) + size_[0] * static_cast<std::size_t>(b);
          const double distance2 = (di * di + dk * dk) * column_size * column_size;
          if (distance2 < 1e-4 && organ_front_[c] == organ_front_[c])
            organ = std::max(organ, static_cast<double>(organ_front_[c]));
          if (skin_[c] != skin_[c]) continue;
          const double w = std::exp(-distance2 / (2 * 12 * mm * 12 * mm));
          sum += w * (inner_y(c) - model_y(x_of(c), z_of(c)));
          weight += w;
        }
      const std::size_t here = i + size_[0] * k;
      const double y = model_y(x_of(here), z_of(here));
      correction_[here] = static_cast<float>(std::max(sum / weight, organ + clearance - y));
    }
  });
}

double AbdominalWall::rest_y(double x, double z) const {
  const double a = std::clamp((x - origin_[0]) / column_size, 0.0, static_cast<double>(size_[0] - 1));
  const double b = std::clamp((z - origin_[1]) / column_size, 0.0, static_cast<double>(size_[1] - 1));
  const auto i = static_cast<std::size_t>(a), k = static_cast<std::size_t>(b);
  const double u = a - static_cast<double>(i), v = b - static_cast<double>(k);
  const auto at = [&](std::size_t di, std::size_t dk) {
    return static_cast<double>(correction_[std::min(i + di, size_[0] - 1) + size_[0] * std::min(k + dk, size_[1] - 1)]);
  };
  const double correction = (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
  // Outside the field the correction of its border fades out.
  const double outside = std::hypot(x - (origin_[0] + a * column_size), z - (origin_[1] + b * column_size));
  return model_y(x, z) + correction * std::exp(-outside / (60 * mm));
}

Vec3 AbdominalWall::lifted(double x, double z) const {
  const double u = (x - midline_) / half_width_, w = (z - umbilicus_z_) / dome_reach;
  const double dome = std::max(0.0, 1 - u * u) * std::max(0.0, 1 - w * w);
  return {x, rest_y(x, z) + lift * dome, z};
}

}  // namespace calot
