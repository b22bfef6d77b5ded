#include "app/patient_preview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <set>

#include "calot/base/parallel.h"
#include "calot/mesh/surface.h"
#include "calot/picture/slices.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;
constexpr int panel_width = 600, view_height = 560, slice_height = 560;
const Vec3 port_color{0.20, 0.42, 0.78}, clip_color{0.80, 0.83, 0.88}, cut_color{0.08, 0.08, 0.10},
    triangle_color{0.05, 0.62, 0.35}, shaft_color{0.55, 0.60, 0.68};

Vec3 color_of(const Patient& patient, Structure s) {
  const auto found = patient.appearances.find(s);
  const Appearance a = found != patient.appearances.end() ? found->second : appearance_of(s);
  return {a.red, a.green, a.blue};
}

/// What is drawn see-through needs a stronger colour to be seen at all.
Vec3 body_color(const Patient& patient, Structure s) {
  const Vec3 color = color_of(patient, s);
  return s == Structure::liver ? Vec3((0.62 / std::max(0.05, color.maxCoeff()) * color).cwiseMin(1.0)) : color;
}

/// What shares a colour shares an entry in the legend.
std::string legend_name(Structure s) {
  switch (s) {
    case Structure::cystic_duct:
    case Structure::common_bile_duct:
    case Structure::common_hepatic_duct:
    case Structure::aberrant_right_duct:
      return "ducts";
    case Structure::cystic_artery:
    case Structure::second_cystic_artery:
    case Structure::right_hepatic_artery:
      return "arteries";
    default:
      return std::string(name_of(s));
  }
}

/// Bright enough for a thin line on grey.
Vec3 outline_color(const Vec3& color) {
  return (0.85 / std::max(0.05, color.maxCoeff()) * color + Vec3::Constant(0.12)).cwiseMin(1.0);
}

double opacity_of(Structure s) {
  switch (s) {
    case Structure::liver:
      return 0.38;
    case Structure::hepatocystic_fat:
      return 0.30;
    case Structure::gallbladder_bed:
    case Structure::gallbladder_wall:
      return 0.55;
    default:
      return 1;
  }
}

Vec3 middle_of(const CalotTriangle& t) {
  return (t.duct_corner + t.neck_corner + t.liver_corner) / 3;
}

/// Everything that the views show, and the surfaces behind it.
class Scenery {
 public:
  explicit Scenery(const Patient& patient);
  [[nodiscard]] const std::vector<PictureItem>& organs() const { return organs_; }
  /// Organs and marks; with the instruments where wanted.
  [[nodiscard]] std::vector<PictureItem> all(bool instruments) const;
  [[nodiscard]] const std::vector<std::pair<std::string, Vec3>>& legend() const { return legend_; }

 private:
  void add_organs(const Patient& patient);
  void add_marks(const Landmarks& landmarks);
  void add_instruments(const Landmarks& landmarks);
  void add(std::vector<PictureItem>& items, Surface surface, const Vec3& color, double opacity = 1);

  std::deque<Surface> surfaces_;  // items point to them
  std::vector<PictureItem> organs_, marks_, instruments_;
  std::vector<std::pair<std::string, Vec3>> legend_;
};

void Scenery::add(std::vector<PictureItem>& items, Surface surface, const Vec3& color, double opacity) {
  surfaces_.push_back(std::move(surface));
  PictureItem item;
  item.surface = &surfaces_.back();
  item.color = color;
  item.opacity = opacity;
  items.push_back(item);
}

void Scenery::add_organs(const Patient& patient) {
  const std::set<std::int32_t> regions(patient.mesh.regions.begin(), patient.mesh.regions.end());
  for (const std::int32_t region : regions) {
    const auto s = static_cast<Structure>(region);
    add(organs_, region_surface(patient.mesh, region), body_color(patient, s), opacity_of(s));
    const auto known = [&](const auto& entry) { return entry.first == legend_name(s); };
    if (std::none_of(legend_.begin(), legend_.end(), known))
      legend_.emplace_back(legend_name(s), body_color(patient, s));
  }
}

void Scenery::add_marks(const Landmarks& landmarks) {
  for (const TubeSite& clip : landmarks.clips)
    add(marks_, ball_surface(std::array{clip.position}, clip.radius + 0.8 * mm), clip_color);
  for (const TubeSite& cut : landmarks.cuts)
    add(marks_, ball_surface(std::array{cut.position}, cut.radius + 0.7 * mm), cut_color);
  const CalotTriangle& t = landmarks.triangle;
  std::vector<Vec3> dots;
  for (const auto& [from, to] : {std::pair{t.duct_corner, t.neck_corner}, std::pair{t.neck_corner, t.liver_corner},
                                 std::pair{t.liver_corner, t.duct_corner}}) {
    const int count = std::clamp(static_cast<int>((to - from).norm() / (1.6 * mm)), 2, 60);
    for (int d = 0; d < count; ++d) dots.emplace_back(from + static_cast<double>(d) / count * (to - from));
  }
  add(marks_, ball_surface(dots, 0.6 * mm), triangle_color);
  for (const auto& [words, color] :
       {std::pair{"clips", clip_color}, std::pair{"cuts", cut_color}, std::pair{"Calot's triangle", triangle_color},
        std::pair{"ports", port_color}, std::pair{"laparoscope and instruments", shaft_color}})
    legend_.emplace_back(words, color);
}

void Scenery::add_instruments(const Landmarks& landmarks) {
  const Vec3 target = middle_of(landmarks.triangle);
  for (const Port& port : landmarks.ports) {
    add(instruments_, ball_surface(std::array{port.position}, 0.7 * port.diameter), port_color);
    if (port.name == "camera")
      add(instruments_, arrow_surface(port.position, landmarks.camera.tip, 1.6 * mm), shaft_color);
    else if (port.name == "epigastric" || port.name == "midclavicular")
      add(instruments_, arrow_surface(port.position, port.position + 0.85 * (target - port.position), 1.0 * mm),
          shaft_color);
  }
}

Scenery::Scenery(const Patient& patient) {
  add_organs(patient);
  add_marks(patient.landmarks);
  add_instruments(patient.landmarks);
}

std::vector<PictureItem> Scenery::all(bool instruments) const {
  std::vector<PictureItem> items = organs_;
  items.insert(items.end(), marks_.begin(), marks_.end());
  if (instruments) items.insert(items.end(), instruments_.begin(), instruments_.end());
  return items;
}

Image titled(const Image& image, const std::string& title) {
  return stacked({image}, Background::white, title);
}

Image view(const std::vector<PictureItem>& items, const Vec3& direction, const Vec3& up, const std::string& title,
           const std::vector<Vec3>& frame) {
  PictureOptions options;
  options.width = panel_width;
  options.height = view_height;
  options.direction = direction;
  options.up = up;
  if (!frame.empty()) options.frame = PictureFrame{frame};
  return titled(render_picture(items, options), title);
}

Image organ_views(const Patient& patient, const Scenery& scenery) {
  const Landmarks& marks = patient.landmarks;
  const std::vector<Vec3> organs = frame_of(scenery.organs()).points;
  // What the laparoscope has before it: the triangle and a hand's breadth around.
  std::vector<Vec3> close;
  const Vec3 target = middle_of(marks.triangle);
  for (int corner = 0; corner < 8; ++corner)
    close.emplace_back(
        target + 24 * mm * Vec3((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1));
  Vec3 gaze = marks.camera.target - marks.camera.tip, up = marks.camera.up;
  if (!(gaze.norm() > 0 && up.cross(gaze).norm() > 1e-3 * gaze.norm())) gaze = {0, -1, 0.3}, up = {0, 0, 1};
  return beside({view(scenery.all(true), {-0.12, -1, -0.12}, {0, 0, 1}, "from the front", {}),
                 view(scenery.all(false), {-1, 0.05, 0.12}, {0, 0, 1}, "from the patient's right", organs),
                 view(scenery.all(false), gaze, up, "as the laparoscope looks", close)});
}

/// Samples the anatomy on a plane: rows and columns of square pixels, along two directions from the upper left.
struct Plane {
  Vec3 corner, across, down;  // [m]; unit directions
  int columns, rows;
  double step;
};

double hounsfield_at(const CtImage& ct, const Vec3& voxel) {
  std::array<std::size_t, 3> low{};
  Vec3 t;
  for (std::size_t d = 0; d < 3; ++d) {
    const auto axis = static_cast<Eigen::Index>(d);
    const double last = static_cast<double>(ct.grid.size[d] - 1);
    if (!(voxel[axis] >= -0.5 && voxel[axis] <= last + 0.5)) return -1024;
    const double inside = std::clamp(voxel[axis], 0.0, last);
    low[d] = std::min(static_cast<std::size_t>(inside), ct.grid.size[d] - (ct.grid.size[d] > 1 ? 2 : 1));
    t[axis] = inside - static_cast<double>(low[d]);
  }
  double sum = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    double weight = 1;
    std::array<std::size_t, 3> at = low;
    for (std::size_t d = 0; d < 3; ++d) {
      const bool high = (c >> d & 1) != 0;
      weight *= high ? t[static_cast<Eigen::Index>(d)] : 1 - t[static_cast<Eigen::Index>(d)];
      if (high) at[d] = std::min(at[d] + 1, ct.grid.size[d] - 1);
    }
    sum += weight * ct.hounsfield[ct.grid.index(at[0], at[1], at[2])];
  }
  return sum;
}

Label label_at(const LabelMap& labels, const Vec3& voxel) {
  std::array<std::size_t, 3> at{};
  for (std::size_t d = 0; d < 3; ++d) {
    const double rounded = std::round(voxel[static_cast<Eigen::Index>(d)]);
    if (!(rounded >= 0 && rounded < static_cast<double>(labels.grid.size[d]))) return 0;
    at[d] = static_cast<std::size_t>(rounded);
  }
  return labels.voxels[labels.grid.index(at[0], at[1], at[2])];
}

Image slice_picture(const Patient& patient, const CompletedAnatomy& anatomy, const Plane& plane, SliceView slice) {
  const std::size_t count = static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows);
  std::vector<std::int16_t> grey(count);
  std::vector<Label> labels(count);
  const Eigen::Affine3d to_voxel = anatomy.labels.grid.to_world.inverse();
  parallel_for(static_cast<std::size_t>(plane.rows), [&](std::size_t row) {
    for (int column = 0; column < plane.columns; ++column) {
      const Vec3 voxel = to_voxel * (plane.corner + plane.step * column * plane.across +
                                     plane.step * static_cast<double>(row) * plane.down);
      const std::size_t at = row * static_cast<std::size_t>(plane.columns) + static_cast<std::size_t>(column);
      grey[at] = static_cast<std::int16_t>(std::lround(hounsfield_at(anatomy.ct, voxel)));
      labels[at] = label_at(anatomy.labels, voxel);
    }
  });
  slice.columns = plane.columns;
  slice.rows = plane.rows;
  slice.grey = grey;
  slice.labels = labels;
  slice.column_size = slice.row_size = plane.step;
  SliceOptions options;
  options.width = panel_width;
  options.height = slice_height;
  for (const Structure s : all_structures()) options.colors[label_of(s)] = outline_color(body_color(patient, s));
  return render_slice(slice, options);
}

/// The labels' box [m] with room around it, and the gallbladder's middle.
struct Extent {
  Eigen::AlignedBox3d box;
  Vec3 gallbladder = Vec3::Zero();
};

Extent extent_of(const LabelMap& labels) {
  Extent extent;
  std::size_t count = 0;
  const auto& n = labels.grid.size;
  for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
    if (labels.voxels[v] == 0) continue;
    const Vec3 p = labels.grid.to_world * Vec3(static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                                               static_cast<double>(v / (n[0] * n[1])));
    extent.box.extend(p);
    if (labels.voxels[v] != label_of(Structure::gallbladder)) continue;
    extent.gallbladder += p;
    ++count;
  }
  if (count > 0) extent.gallbladder /= static_cast<double>(count);
  const double room = 20 * mm;
  return {{Vec3(extent.box.min().array() - room), Vec3(extent.box.max().array() + room)}, extent.gallbladder};
}

std::string at_mm(const char* words, double metres) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "%s = %ld mm", words, std::lround(metres / mm));
  std::string result = text.data();
  const std::size_t minus = result.find('-');
  if (minus != std::string::npos) result.replace(minus, 1, "\u2212");
  return result;
}

/// Radiologists' convention: the patient's right is on the left, the front on top or, in sagittal slices, on the left.
Image slices(const Patient& patient, const CompletedAnatomy& anatomy) {
  const Extent extent = extent_of(anatomy.labels);
  const Vec3 low = extent.box.min(), high = extent.box.max(), triangle = middle_of(patient.landmarks.triangle);
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  const double step = std::max(0.3 * mm, anatomy.ct.grid.spacing().minCoeff());
  const auto plane = [&](const Vec3& corner, const Vec3& across, const Vec3& down) {
    const auto steps = [&](const Vec3& along) {
      return std::clamp(static_cast<int>(along.cwiseAbs().dot(high - low) / step), 2, 4000);
    };
    return Plane{corner, across, down, steps(across), steps(down), step};
  };
  SliceView axial, coronal, sagittal;
  axial.title = at_mm("axial through Calot's triangle, z", triangle[2]);
  axial.left = std::string("R"), axial.right = std::string("L");
  axial.top = std::string("A"), axial.bottom = std::string("P");
  coronal.title = at_mm("coronal through Calot's triangle, y", triangle[1]);
  coronal.left = std::string("R"), coronal.right = std::string("L");
  coronal.top = std::string("S"), coronal.bottom = std::string("I");
  sagittal.title = at_mm("sagittal through the gallbladder, x", extent.gallbladder[0]);
  sagittal.left = std::string("A"), sagittal.right = std::string("P");
  sagittal.top = std::string("S"), sagittal.bottom = std::string("I");
  return beside({slice_picture(patient, anatomy, plane({high[0], high[1], triangle[2]}, -x, -y), axial),
                 slice_picture(patient, anatomy, plane({high[0], triangle[1], high[2]}, -x, -z), coronal),
                 slice_picture(patient, anatomy, plane({extent.gallbladder[0], high[1], high[2]}, -y, -z), sagittal)});
}

}  // namespace

Image patient_preview(const Patient& patient, const CompletedAnatomy& anatomy) {
  const Scenery scenery(patient);
  return stacked(
      {organ_views(patient, scenery), color_legend(scenery.legend(), 3 * panel_width), slices(patient, anatomy)},
      Background::white, patient.name);
}

}  // namespace calot
