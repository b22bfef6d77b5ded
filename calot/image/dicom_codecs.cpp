// JPEG 2000 is decoded by OpenJPEG, not through GDCM: GDCM 3.0 asserts that streams are whole, and writes beyond its
// buffer where a stream is larger than the header says. JPEG and JPEG-LS go through GDCM's codecs; their sizes are
// checked first.
#include "calot/image/dicom_codecs.h"

#include <gdcmJPEGCodec.h>
#include <gdcmJPEGLSCodec.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>
#include <openjpeg.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace calot {
namespace {

std::string joined(const std::vector<std::string_view>& fragments) {
  std::string all;
  for (const std::string_view fragment : fragments) all += fragment;
  return all;
}

// ---- JPEG 2000

/// What OpenJPEG's stream reads from.
struct Memory {
  std::string_view bytes;
  std::size_t at = 0;

  static OPJ_SIZE_T read(void* into, OPJ_SIZE_T count, void* self) {
    auto* const memory = static_cast<Memory*>(self);
    const std::size_t got = std::min(count, memory->bytes.size() - memory->at);
    if (got == 0) return static_cast<OPJ_SIZE_T>(-1);
    std::memcpy(into, memory->bytes.data() + memory->at, got);
    memory->at += got;
    return got;
  }
  static OPJ_OFF_T skip(OPJ_OFF_T count, void* self) {
    auto* const memory = static_cast<Memory*>(self);
    if (count < 0 || static_cast<std::size_t>(count) > memory->bytes.size() - memory->at) return -1;
    memory->at += static_cast<std::size_t>(count);
    return count;
  }
  static OPJ_BOOL seek(OPJ_OFF_T to, void* self) {
    auto* const memory = static_cast<Memory*>(self);
    if (to < 0 || static_cast<std::size_t>(to) > memory->bytes.size()) return OPJ_FALSE;
    memory->at = static_cast<std::size_t>(to);
    return OPJ_TRUE;
  }
};

using Stream = std::unique_ptr<opj_stream_t, decltype(&opj_stream_destroy)>;
using Codec = std::unique_ptr<opj_codec_t, decltype(&opj_destroy_codec)>;
using Image = std::unique_ptr<opj_image_t, decltype(&opj_image_destroy)>;

Stream stream_from(Memory& memory) {
  Stream stream(opj_stream_default_create(OPJ_TRUE), opj_stream_destroy);
  opj_stream_set_user_data(stream.get(), &memory, nullptr);
  opj_stream_set_user_data_length(stream.get(), memory.bytes.size());
  opj_stream_set_read_function(stream.get(), Memory::read);
  opj_stream_set_skip_function(stream.get(), Memory::skip);
  opj_stream_set_seek_function(stream.get(), Memory::seek);
  return stream;
}

bool fits(const opj_image_t& image, const PixelLayout& layout) {
  if (image.numcomps != 1) return false;
  const opj_image_comp_t& pixels = image.comps[0];
  return pixels.w == layout.columns && pixels.h == layout.rows && pixels.prec >= 1 && pixels.prec <= 8 * layout.bytes;
}

std::string decode_jpeg2000(const std::string& bytes, PixelLayout& layout, std::vector<char>& pixels) {
  Memory memory{bytes, 0};
  const Stream stream = stream_from(memory);
  const bool boxed = bytes.starts_with(std::string_view("\0\0\0\x0cjP", 6));  // .jp2, where only its content belongs
  const Codec codec(opj_create_decompress(boxed ? OPJ_CODEC_JP2 : OPJ_CODEC_J2K), opj_destroy_codec);
  opj_dparameters_t parameters;
  opj_set_default_decoder_parameters(&parameters);
  opj_image_t* made = nullptr;
  const bool begun = opj_setup_decoder(codec.get(), &parameters) &&
                     opj_decoder_set_strict_mode(codec.get(), OPJ_TRUE) &&
                     opj_read_header(stream.get(), codec.get(), &made);
  const Image image(made, opj_image_destroy);
  if (!begun) return "its JPEG 2000 header is damaged";
  // Sizes are checked before anything of that size is made.
  if (image->numcomps != 1 || image->x1 - image->x0 != layout.columns || image->y1 - image->y0 != layout.rows)
    return "its JPEG 2000 image has another size than its header says";
  if (!opj_decode(codec.get(), stream.get(), image.get()) || !image->comps[0].data || !fits(*image, layout))
    return "its JPEG 2000 data is damaged or truncated";
  layout.is_signed = image->comps[0].sgnd != 0;
  layout.bits_stored = static_cast<int>(image->comps[0].prec);
  for (std::size_t p = 0; p < layout.count(); ++p)
    std::memcpy(pixels.data() + p * layout.bytes, &image->comps[0].data[p], layout.bytes);
  return {};
}

// ---- JPEG and JPEG-LS

/// Size and precision in a JPEG stream's frame header. Source: ITU-T T.81, §B.2.2; T.87, §C.2.2.
struct JpegFrame {
  std::size_t rows = 0, columns = 0, components = 0;
  int precision = 0;
};

bool read_frame(std::string_view bytes, JpegFrame& frame) {
  const auto byte = [&](std::size_t at) { return static_cast<std::size_t>(static_cast<unsigned char>(bytes[at])); };
  if (bytes.size() < 4 || byte(0) != 0xff || byte(1) != 0xd8) return false;
  for (std::size_t at = 2; at + 9 < bytes.size();) {
    if (byte(at) != 0xff) return false;
    const std::size_t marker = byte(at + 1);
    if (marker == 0xff) {
      ++at;
      continue;
    }
    const bool frame_marker =
        (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) || marker == 0xf7;
    if (frame_marker) {
      frame = {byte(at + 5) << 8 | byte(at + 6), byte(at + 7) << 8 | byte(at + 8), byte(at + 9),
               static_cast<int>(byte(at + 4))};
      return true;
    }
    at += 2 + (byte(at + 2) << 8 | byte(at + 3));
  }
  return false;
}

/// What matters comes back as a message.
void silence_gdcm() {
  static const bool once = [] {
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    return true;
  }();
  static_cast<void>(once);
}

template <class JpegCodec>
std::string decode_with_gdcm(std::string bytes, PixelLayout& layout, std::vector<char>& pixels) {
  silence_gdcm();
  JpegFrame frame;
  if (!read_frame(bytes, frame)) return "its JPEG header is damaged";
  if (frame.components != 1 || frame.rows != layout.rows || frame.columns != layout.columns || frame.precision < 2 ||
      static_cast<std::size_t>(frame.precision + 7) / 8 != layout.bytes)
    return "its JPEG image has another size than its header says";
  if (bytes.size() % 2) bytes += '\0';
  gdcm::Fragment fragment;
  fragment.SetTag(gdcm::Tag(0xfffe, 0xe000));
  fragment.SetByteValue(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  auto* const fragments = new gdcm::SequenceOfFragments;  // `in` counts its users, and deletes it
  fragments->AddFragment(fragment);
  gdcm::DataElement in(gdcm::Tag(0x7fe0, 0x0010)), out;
  in.SetValue(*fragments);
  const auto bits = static_cast<unsigned short>(8 * layout.bytes),
             precision = static_cast<unsigned short>(frame.precision);
  const unsigned int size[3] = {static_cast<unsigned>(layout.columns), static_cast<unsigned>(layout.rows), 1};
  JpegCodec codec;
  codec.SetNumberOfDimensions(2);
  codec.SetDimensions(size);
  codec.SetPlanarConfiguration(0);
  codec.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  codec.SetPixelFormat(gdcm::PixelFormat(1, bits, precision, static_cast<unsigned short>(precision - 1), 0));
  const bool decoded = codec.Decode(in, out) && out.GetByteValue() && out.GetByteValue()->GetLength() >= pixels.size();
  if (!decoded) return "its JPEG data is damaged or truncated";
  std::memcpy(pixels.data(), out.GetByteValue()->GetPointer(), pixels.size());
  return {};
}

// ---- run lengths: one plane for each byte of a pixel, the highest first. Source: DICOM, part 5, annex G.

/// @return whether the plane was filled
bool unpack_runs(std::string_view packed, std::size_t count, std::size_t stride, char* plane) {
  std::size_t done = 0;
  while (done < count && packed.size() >= 2) {
    const auto head = static_cast<signed char>(packed[0]);
    packed.remove_prefix(1);
    if (head == -128) continue;
    const bool run = head < 0;
    const std::size_t length = static_cast<std::size_t>(run ? 1 - head : head + 1);
    if (length > count - done || (!run && length > packed.size())) return false;
    for (std::size_t n = 0; n < length; ++n, ++done) plane[done * stride] = packed[run ? 0 : n];
    packed.remove_prefix(run ? 1 : length);
  }
  return done == count;
}

std::string decode_runs(std::string_view bytes, const PixelLayout& layout, std::vector<char>& pixels) {
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + 4 * at, 4);
    return static_cast<std::size_t>(value);
  };
  const char* const damaged = "its run lengths (RLE) are damaged or truncated";
  if (bytes.size() < 64 || word(0) != layout.bytes) return damaged;
  for (std::size_t plane = 0; plane < layout.bytes; ++plane) {
    const std::size_t begin = word(1 + plane), end = plane + 1 < layout.bytes ? word(2 + plane) : bytes.size();
    if (begin < 64 || begin > end || end > bytes.size()) return damaged;
    if (!unpack_runs(bytes.substr(begin, end - begin), layout.count(), layout.bytes,
                     pixels.data() + (layout.bytes - 1 - plane)))
      return damaged;
  }
  return {};
}

}  // namespace

std::string decode_pixels(const std::string& transfer_syntax, const std::vector<std::string_view>& fragments,
                          PixelLayout& layout, std::vector<char>& pixels) {
  const std::string bytes = joined(fragments), kind = "1.2.840.10008.1.2.";
  pixels.assign(layout.count() * layout.bytes, 0);
  if (transfer_syntax == kind + "5") return decode_runs(bytes, layout, pixels);
  if (transfer_syntax == kind + "4.90" || transfer_syntax == kind + "4.91")
    return decode_jpeg2000(bytes, layout, pixels);
  if (transfer_syntax == kind + "4.80" || transfer_syntax == kind + "4.81")
    return decode_with_gdcm<gdcm::JPEGLSCodec>(bytes, layout, pixels);
  if (transfer_syntax == kind + "4.70" || transfer_syntax == kind + "4.57" || transfer_syntax == kind + "4.50" ||
      transfer_syntax == kind + "4.51")
    return decode_with_gdcm<gdcm::JPEGCodec>(bytes, layout, pixels);
  return "its pixels are compressed in a way that can't be undone";
}

}  // namespace calot
