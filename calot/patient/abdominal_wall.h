// The inner side of the abdominal wall: from the skin in the CT where its field reaches it, assumed where it doesn't.
#pragma once
#include <string>
#include <vector>

#include "calot/patient/completion.h"

namespace calot {

namespace detail {
struct BodyScan;
}

/// The front wall as a height over the coronal plane, in RAS [m].
class AbdominalWall {
 public:
  /// @param bile_duct  where the cystic duct meets it
  /// @param notes      gets what had to be assumed, in words
  AbdominalWall(const CompletedAnatomy& anatomy, const Vec3& bile_duct, std::vector<std::string>& notes);

  [[nodiscard]] double midline() const { return midline_; }        ///< x [m]
  [[nodiscard]] double half_width() const { return half_width_; }  ///< of the cavity [m]
  [[nodiscard]] double thickness() const { return thickness_; }    ///< of the wall, skin to peritoneum [m]
  [[nodiscard]] bool skin_seen() const { return skin_seen_; }
  /// The inner side at rest: y [m] at x, z.
  [[nodiscard]] double rest_y(double x, double z) const;
  /// The inner side over the gas: lifted most at the umbilicus, not at all at the flanks and the costal arch.
  [[nodiscard]] Vec3 lifted(double x, double z) const;
  /// Says where the umbilicus is: the dome is highest there.
  void set_umbilicus(double z) { umbilicus_z_ = z; }

 private:
  void find_midline(const detail::BodyScan& scan, const Vec3& bile_duct, std::vector<std::string>& notes);
  void find_skin(const detail::BodyScan& scan);
  void find_thickness(const detail::BodyScan& scan, std::vector<std::string>& notes);
  void fit_front(std::vector<std::string>& notes);
  void fit_to_skin();
  void fit_to_organs();
  void spread_correction();
  [[nodiscard]] double model_y(double x, double z) const;
  [[nodiscard]] double bulge_at(double x) const;
  [[nodiscard]] double steepness(double x) const;
  [[nodiscard]] double inner_y(std::size_t c) const;  ///< behind the skin of a column [m]; NaN without
  [[nodiscard]] double x_of(std::size_t c) const {
    return origin_[0] + column_size * static_cast<double>(c % size_[0]);
  }
  [[nodiscard]] double z_of(std::size_t c) const {
    return origin_[1] + column_size * static_cast<double>(c / size_[0]);
  }

  static constexpr double column_size = 4e-3;  // [m]
  double midline_ = 0, half_width_ = 0, thickness_ = 0, umbilicus_z_ = 0;
  bool skin_seen_ = false;
  // y = front_ + bulge_ · √(1 − u²) + slope_ · (z − middle_z_), u the distance from the midline over half_width_; plus
  // a correction by the columns that see the skin.
  double front_ = 0, bulge_ = 0, slope_ = 0, middle_z_ = 0;
  // Columns along y, on a grid over x and z.
  std::array<std::size_t, 2> size_{};
  Eigen::Vector2d origin_;
  std::vector<float> skin_, organ_front_;  // y [m]; NaN where there is none
  std::vector<float> correction_;          // [m]
};

}  // namespace calot
