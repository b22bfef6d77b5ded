#include "calot/sound/al_device.h"

#include <dlfcn.h>

#include <array>

#include "calot/sound/sounds.h"

namespace calot::detail {

namespace {

template <class Function>
Function alc_function(const char* name) {
  return reinterpret_cast<Function>(alcGetProcAddress(nullptr, name));
}

/// ALSA prints a page on stderr when there is no card; the player says it in one line instead. Its default comes back
/// after.
class AlsaHush {
 public:
  AlsaHush() : library_(dlopen("libasound.so.2", RTLD_LAZY | RTLD_LOCAL)) { set(&say_nothing); }
  ~AlsaHush() {
    set(nullptr);
    if (library_ != nullptr) dlclose(library_);
  }
  AlsaHush(const AlsaHush&) = delete;
  AlsaHush& operator=(const AlsaHush&) = delete;

 private:
  using Handler = void (*)(const char*, int, const char*, int, const char*, ...);
  static void say_nothing(const char*, int, const char*, int, const char*, ...) {}
  void set(Handler handler) {
    if (library_ == nullptr) return;
    using Setter = int (*)(Handler);
    if (const auto setter = reinterpret_cast<Setter>(dlsym(library_, "snd_lib_error_set_handler"))) setter(handler);
  }
  void* library_;
};

}  // namespace

AlDevice::Current::Current(const AlDevice& device)
    : before_(alc_function<PFNALCGETTHREADCONTEXTPROC>("alcGetThreadContext")()) {
  alc_function<PFNALCSETTHREADCONTEXTPROC>("alcSetThreadContext")(device.context_);
}

AlDevice::Current::~Current() {
  alc_function<PFNALCSETTHREADCONTEXTPROC>("alcSetThreadContext")(before_);
}

std::unique_ptr<AlDevice> AlDevice::with_context(ALCdevice* device, const ALCint* attributes, std::string& why_not) {
  ALCcontext* context = alcIsExtensionPresent(nullptr, "ALC_EXT_thread_local_context") == ALC_TRUE
                            ? alcCreateContext(device, attributes)
                            : nullptr;
  if (context == nullptr) {
    why_not = "the sound device gives no context";
    alcCloseDevice(device);
    return nullptr;
  }
  return std::unique_ptr<AlDevice>(new AlDevice(device, context));
}

std::unique_ptr<AlDevice> AlDevice::open(const std::string& name, std::string& why_not) {
  const AlsaHush hush;
  ALCdevice* device = alcOpenDevice(name.empty() ? nullptr : name.c_str());
  if (device == nullptr) {
    why_not = name.empty() ? "no sound device" : "no sound device named \"" + name + "\"";
    return nullptr;
  }
  // Periods of 10 ms: a sound starts at the next one.
  const std::array<ALCint, 5> attributes = {ALC_FREQUENCY, kSampleRate, ALC_REFRESH, 100, 0};
  return with_context(device, attributes.data(), why_not);
}

std::unique_ptr<AlDevice> AlDevice::loopback(std::string& why_not) {
  const auto open_loopback = alc_function<LPALCLOOPBACKOPENDEVICESOFT>("alcLoopbackOpenDeviceSOFT");
  ALCdevice* device = open_loopback != nullptr ? open_loopback(nullptr) : nullptr;
  if (device == nullptr) {
    why_not = "this OpenAL can't render into memory (ALC_SOFT_loopback)";
    return nullptr;
  }
  const std::array<ALCint, 9> attributes = {ALC_FORMAT_CHANNELS_SOFT,
                                            ALC_STEREO_SOFT,
                                            ALC_FORMAT_TYPE_SOFT,
                                            ALC_FLOAT_SOFT,
                                            ALC_FREQUENCY,
                                            kSampleRate,
                                            ALC_HRTF_SOFT,
                                            ALC_FALSE,
                                            0};
  return with_context(device, attributes.data(), why_not);
}

AlDevice::~AlDevice() {
  alcDestroyContext(context_);
  alcCloseDevice(device_);
}

std::string AlDevice::name() const {
  const ALCchar* name = alcGetString(device_, ALC_ALL_DEVICES_SPECIFIER);
  return name != nullptr ? name : "unnamed";
}

bool AlDevice::connected() const {
  if (alcIsExtensionPresent(device_, "ALC_EXT_disconnect") != ALC_TRUE) return true;
  ALCint connected = 1;
  alcGetIntegerv(device_, ALC_CONNECTED, 1, &connected);
  return connected != 0;
}

void AlDevice::render(float* stereo, int samples) {
  static const auto render_samples = alc_function<LPALCRENDERSAMPLESSOFT>("alcRenderSamplesSOFT");
  render_samples(device_, stereo, samples);
}

}  // namespace calot::detail
