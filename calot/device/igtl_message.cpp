#include "calot/device/igtl_message.h"

#include <igtl_header.h>
#include <igtl_position.h>
#include <igtl_sensor.h>
#include <igtl_transform.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace calot {
namespace {

constexpr double mm = 1e-3;
constexpr std::size_t extended_header_size = 12;  // at least, of version 2

// The library's own byte order and checksums, on memory whose size has been checked here.
std::uint64_t checksum_of(std::span<std::uint8_t> bytes) {
  return crc64(bytes.data(), bytes.size(), crc64(nullptr, 0, 0));
}

template <class Number>
Number big_endian(std::span<const std::uint8_t> bytes) {
  Number number = 0;
  for (std::size_t k = 0; k < sizeof(Number); ++k) number = static_cast<Number>(number << 8 | bytes[k]);
  return number;
}

void append_u32(std::vector<std::uint8_t>& out, std::uint32_t number) {
  for (const int shift : {24, 16, 8, 0}) out.push_back(static_cast<std::uint8_t>(number >> shift));
}

/// Text of a field that ends with zeros; none where it isn't printable.
std::optional<std::string_view> text_in(std::span<const std::uint8_t> field) {
  const auto end = std::find(field.begin(), field.end(), 0);
  const auto printable = [](std::uint8_t c) { return c >= 0x20 && c < 0x7f; };
  if (!std::all_of(field.begin(), end, printable)) return {};
  return std::string_view(reinterpret_cast<const char*>(field.data()), static_cast<std::size_t>(end - field.begin()));
}

/// Reserves the header; `close_message` fills it in when the body is there.
std::size_t open_message(std::vector<std::uint8_t>& out) {
  out.resize(out.size() + IgtlReader::header_size);
  return out.size() - IgtlReader::header_size;
}

void close_message(std::vector<std::uint8_t>& out, std::size_t at, std::string_view type, std::string_view device) {
  igtl_header header{};
  static_assert(sizeof header == IgtlReader::header_size);
  const std::span<std::uint8_t> body(out.data() + at + sizeof header, out.size() - at - sizeof header);
  header.version = IGTL_HEADER_VERSION;
  std::memcpy(header.name, type.data(), std::min<std::size_t>(type.size(), IGTL_HEADER_TYPE_SIZE));
  std::memcpy(header.device_name, device.data(), std::min<std::size_t>(device.size(), IGTL_HEADER_NAME_SIZE - 1));
  header.body_size = body.size();
  header.crc = checksum_of(body);
  igtl_header_convert_byte_order(&header);
  std::memcpy(out.data() + at, &header, sizeof header);
}

std::optional<Pose> sound(const Eigen::Matrix3d& rotation, const Vec3& position) {
  constexpr double furthest = 10, skew = 1e-2;  // m; of a float32 matrix that was rounded on the way
  if (!rotation.allFinite() || !position.allFinite() || position.cwiseAbs().maxCoeff() > furthest) return {};
  if ((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > skew) return {};
  if (rotation.determinant() < 0) return {};
  return Pose{Eigen::Quaterniond(rotation).normalized(), position};
}

std::optional<Pose> transform_in(std::span<const std::uint8_t> content) {
  std::array<igtl_float32, 12> m{};
  if (content.size() != IGTL_TRANSFORM_SIZE) return {};
  std::memcpy(m.data(), content.data(), IGTL_TRANSFORM_SIZE);
  igtl_transform_convert_byte_order(m.data());
  // Column by column: three axes, then the place.
  Eigen::Matrix3d rotation;
  for (int k = 0; k < 9; ++k) rotation(k % 3, k / 3) = static_cast<double>(m[static_cast<std::size_t>(k)]);
  return sound(rotation, mm * Vec3(m[9], m[10], m[11]));
}

std::optional<Pose> position_in(std::span<const std::uint8_t> content) {
  igtl_position p{};
  if (content.size() != IGTL_POSITION_MESSAGE_POSITON_ONLY_SIZE &&
      content.size() != IGTL_POSITION_MESSAGE_WITH_QUATERNION3_SIZE &&
      content.size() != IGTL_POSITION_MESSAGE_DEFAULT_SIZE)
    return {};
  std::memcpy(&p, content.data(), content.size());
  igtl_position_convert_byte_order(&p);
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  if (content.size() > IGTL_POSITION_MESSAGE_POSITON_ONLY_SIZE) {
    q.vec() = Vec3(p.quaternion[0], p.quaternion[1], p.quaternion[2]);
    q.w() = content.size() == IGTL_POSITION_MESSAGE_DEFAULT_SIZE ? static_cast<double>(p.quaternion[3])
                                                                 : std::sqrt(std::max(0.0, 1 - q.vec().squaredNorm()));
  }
  if (!(std::abs(q.norm() - 1) < 1e-2)) return {};
  return sound(q.normalized().toRotationMatrix(), mm * Vec3(p.position[0], p.position[1], p.position[2]));
}

}  // namespace

std::string_view words_of(IgtlFault fault) {
  switch (fault) {
    case IgtlFault::none:
      return "nothing wrong";
    case IgtlFault::version:
      return "a version of OpenIGTLink that Calot doesn't know (it knows 1 and 2), or no OpenIGTLink at all";
    case IgtlFault::not_igtl:
      return "what isn't OpenIGTLink";
    case IgtlFault::too_large:
      return "a message larger than 4096 bytes";
    case IgtlFault::checksum:
      return "a message whose checksum is wrong";
  }
  return "";
}

std::size_t IgtlReader::take(std::span<const std::uint8_t> bytes) {
  if (fault_ != IgtlFault::none) return 0;
  whole_ = false;
  std::size_t taken = 0;
  while (!whole_ && fault_ == IgtlFault::none) {
    const std::size_t part = std::min(wanted_ - filled_, bytes.size() - taken);
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(taken), part,
                bytes_.begin() + static_cast<std::ptrdiff_t>(filled_));
    filled_ += part;
    taken += part;
    if (filled_ < wanted_) break;
    if (!has_header_)
      read_header();
    else
      finish();
  }
  return taken;
}

void IgtlReader::read_header() {
  const std::span<const std::uint8_t> h(bytes_);
  version_ = big_endian<std::uint16_t>(h.subspan(0, 2));
  const auto type = text_in(h.subspan(2, 12)), device = text_in(h.subspan(14, 20));
  const auto size = big_endian<std::uint64_t>(h.subspan(42, 8));
  checksum_ = big_endian<std::uint64_t>(h.subspan(50, 8));
  if (version_ < 1 || version_ > 2)
    fault_ = IgtlFault::version;
  else if (!type || type->empty() || !device)
    fault_ = IgtlFault::not_igtl;
  else if (size > largest_body)
    fault_ = IgtlFault::too_large;
  if (fault_ != IgtlFault::none) return;
  type_ = *type;
  device_ = *device;
  wanted_ = header_size + static_cast<std::size_t>(size);
  has_header_ = true;
}

void IgtlReader::finish() {
  const std::span<std::uint8_t> body(bytes_.data() + header_size, wanted_ - header_size);
  has_header_ = false;
  filled_ = 0;
  wanted_ = header_size;
  if (checksum_of(body) != checksum_) {
    fault_ = IgtlFault::checksum;
    return;
  }
  content_ = body;
  if (version_ == 2 && !body.empty()) {
    const std::size_t extended = body.size() < extended_header_size ? 0 : big_endian<std::uint16_t>(body.subspan(0, 2));
    const std::uint64_t meta = extended < extended_header_size
                                   ? 0
                                   : std::uint64_t{big_endian<std::uint16_t>(body.subspan(2, 2))} +
                                         big_endian<std::uint32_t>(body.subspan(4, 4));
    if (extended < extended_header_size || extended > body.size() || meta > body.size() - extended) {
      fault_ = IgtlFault::not_igtl;
      return;
    }
    content_ = body.subspan(extended, body.size() - extended - static_cast<std::size_t>(meta));
  }
  whole_ = true;
}

std::optional<IgtlMessage> IgtlReader::message() {
  if (!whole_) return {};
  whole_ = false;
  return IgtlMessage{type_, device_, content_};
}

std::optional<Pose> igtl_pose(const IgtlMessage& message) {
  if (message.type == "TRANSFORM") return transform_in(message.content);
  if (message.type == "POSITION") return position_in(message.content);
  return {};
}

std::optional<IgtlFingers> igtl_fingers(const IgtlMessage& message) {
  constexpr std::size_t fewest = 4, most = 6;
  constexpr double widest = M_PI, strongest = 1000;  // rad, N
  if (message.type != "SENSOR" || message.content.size() < IGTL_SENSOR_HEADER_SIZE) return {};
  const std::size_t count = message.content[0];
  if (count < fewest || count > most) return {};
  if (message.content.size() != IGTL_SENSOR_HEADER_SIZE + count * sizeof(igtl_float64)) return {};
  igtl_sensor_header header{};
  std::array<igtl_float64, most> value{};
  std::memcpy(&header, message.content.data(), IGTL_SENSOR_HEADER_SIZE);
  std::memcpy(value.data(), message.content.data() + IGTL_SENSOR_HEADER_SIZE, count * sizeof(igtl_float64));
  igtl_sensor_convert_byte_order(&header, value.data());
  if (!std::all_of(value.begin(), value.end(), [](double v) { return std::isfinite(v); })) return {};
  if (value[0] < 0 || value[0] > widest || value[1] < 0 || value[1] > strongest) return {};
  return IgtlFingers{value[0], value[1], value[2] != 0, value[3] != 0, {value[4] != 0, value[5] != 0}};
}

void write_igtl_wrench(std::vector<std::uint8_t>& out, std::string_view device, const HandWrench& wrench) {
  const std::size_t at = open_message(out);
  igtl_sensor_header header{};
  std::array<igtl_float64, 6> value{};
  header.larray = 6;
  for (int k = 0; k < 3; ++k) {
    value[static_cast<std::size_t>(k)] = wrench.force[k];
    value[static_cast<std::size_t>(k) + 3] = wrench.torque[k];
  }
  igtl_sensor_convert_byte_order(&header, value.data());
  const auto* h = reinterpret_cast<const std::uint8_t*>(&header);
  const auto* v = reinterpret_cast<const std::uint8_t*>(value.data());
  out.insert(out.end(), h, h + IGTL_SENSOR_HEADER_SIZE);
  out.insert(out.end(), v, v + sizeof value);
  close_message(out, at, "SENSOR", device);
}

bool IgtlSurfacePacker::pack(std::vector<std::uint8_t>& out, std::string_view device, const OrganSurface& surface) {
  const std::size_t points = surface.positions.size(), triangles = surface.triangles.size();
  if (points == 0 || points > 1'000'000 || triangles > 2'000'000) return false;
  if (!packed_ || topology_ != surface.topology || triangles_ != triangles || points_ != points) {
    packed_ = false;
    polygons_.clear();
    for (const auto& triangle : surface.triangles) {
      append_u32(polygons_, 3);
      for (const std::uint32_t corner : triangle) {
        if (corner >= points) return false;
        append_u32(polygons_, corner);
      }
    }
    topology_ = surface.topology;
    triangles_ = triangles;
    points_ = points;
    packed_ = true;
  }
  const std::size_t at = open_message(out);
  // Points; vertices, lines, polygons and strips with their sizes in bytes; attributes.
  const auto size = static_cast<std::uint32_t>(polygons_.size());
  for (const std::uint32_t number :
       {static_cast<std::uint32_t>(points), 0U, 0U, 0U, 0U, static_cast<std::uint32_t>(triangles), size, 0U, 0U, 0U})
    append_u32(out, number);
  for (const Eigen::Vector3f& x : surface.positions)
    for (int axis = 0; axis < 3; ++axis) append_u32(out, std::bit_cast<std::uint32_t>(1000.0F * x[axis]));
  out.insert(out.end(), polygons_.begin(), polygons_.end());
  close_message(out, at, "POLYDATA", device);
  return true;
}

}  // namespace calot
