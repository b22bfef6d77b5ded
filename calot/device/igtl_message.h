// OpenIGTLink messages: from bytes that anybody may have sent to values that are safe, and back.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calot/device/hand.h"

namespace calot {

/// Why a stream of bytes can't be followed any further.
enum class IgtlFault : std::uint8_t { none, version, not_igtl, too_large, checksum };
std::string_view words_of(IgtlFault fault);

/// A whole message whose checksum is right. Valid until more bytes are read.
struct IgtlMessage {
  std::string_view type, device;          ///< printable, at most 12 and 20 letters
  std::span<const std::uint8_t> content;  ///< without the extended header and metadata of version 2
};

/// Cuts a stream into messages. Keeps one message at most, in memory of fixed size.
class IgtlReader {
 public:
  static constexpr std::size_t header_size = 58, largest_body = 4096;

  /// Takes bytes up to the end of one message. @return how many; 0 after a fault
  std::size_t take(std::span<const std::uint8_t> bytes);
  /// The message that `take` has just finished; once.
  std::optional<IgtlMessage> message();
  [[nodiscard]] IgtlFault fault() const { return fault_; }
  /// Bytes of a message that isn't whole yet.
  [[nodiscard]] bool is_within() const { return filled_ > 0; }

 private:
  void read_header();
  void finish();

  std::array<std::uint8_t, header_size + largest_body> bytes_{};
  std::size_t filled_ = 0, wanted_ = header_size;
  std::uint64_t checksum_ = 0;
  bool has_header_ = false, whole_ = false;
  std::uint16_t version_ = 1;
  std::string_view type_, device_;
  std::span<const std::uint8_t> content_;
  IgtlFault fault_ = IgtlFault::none;
};

/// A handle's pose from a TRANSFORM or POSITION message, mm to m. None for another size, numbers that aren't finite,
/// further than 10 m, or a matrix that is no rotation.
std::optional<Pose> igtl_pose(const IgtlMessage& message);

/// What fingers and feet do, from a SENSOR message of 4 to 6 values: opening [rad], grip [N], pedal, button, clutch,
/// ratchet (the last four: not 0 means on). None for another size, or numbers that aren't finite or are out of range.
struct IgtlFingers {
  double opening = 0, grip = 0;
  bool pedal = false, button = false;
  HandControls controls;
};
std::optional<IgtlFingers> igtl_fingers(const IgtlMessage& message);

/// A SENSOR message of force [N] and torque [N·m].
void write_igtl_wrench(std::vector<std::uint8_t>& out, std::string_view device, const HandWrench& wrench);

/// A surface to be shown elsewhere, in the world's axes.
struct OrganSurface {
  std::uint64_t topology = 0;              ///< another one after each change of the triangles
  std::vector<Eigen::Vector3f> positions;  ///< [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Packs POLYDATA messages: points as float32 in mm, all triangles. Those are packed once for each topology.
class IgtlSurfacePacker {
 public:
  /// @return false where the surface can't be sent: no points, a triangle of points that aren't there
  bool pack(std::vector<std::uint8_t>& out, std::string_view device, const OrganSurface& surface);

 private:
  std::vector<std::uint8_t> polygons_;
  std::uint64_t topology_ = 0;
  std::size_t triangles_ = 0, points_ = 0;
  bool packed_ = false;
};

}  // namespace calot
