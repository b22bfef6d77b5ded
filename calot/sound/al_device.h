// Inside this room only: an OpenAL device with its context, used by one thread at a time.
#pragma once
#include <AL/al.h>
#include <AL/alc.h>
#include <AL/alext.h>

#include <memory>
#include <string>

namespace calot::detail {

class AlDevice {
 public:
  /// Null, with a reason, if there is none.
  static std::unique_ptr<AlDevice> open(const std::string& name, std::string& why_not);
  /// Renders into memory, stereo; not in 16 bits, for OpenAL would add noise (dither) to silence.
  static std::unique_ptr<AlDevice> loopback(std::string& why_not);
  ~AlDevice();
  AlDevice(const AlDevice&) = delete;
  AlDevice& operator=(const AlDevice&) = delete;

  [[nodiscard]] std::string name() const;
  [[nodiscard]] bool connected() const;
  void render(float* stereo, int samples);

  /// While one lives, OpenAL's calls of this thread go to this device. No other thread's are touched.
  class Current {
   public:
    explicit Current(const AlDevice& device);
    ~Current();
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;

   private:
    ALCcontext* before_;
  };

 private:
  AlDevice(ALCdevice* device, ALCcontext* context) : device_(device), context_(context) {}
  static std::unique_ptr<AlDevice> with_context(ALCdevice* device, const ALCint* attributes, std::string& why_not);
  ALCdevice* device_;
  ALCcontext* context_;
};

}  // namespace calot::detail
