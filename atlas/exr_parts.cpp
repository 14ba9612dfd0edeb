#include "atlas/exr_parts.h"

#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <utility>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfThreading.h>
#include <fmt/format.h>

namespace pluvia {
namespace {

class StringOutput : public Imf::OStream {
 public:
  StringOutput() : OStream("memory") {}
  void write(const char* from, int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (bytes.size() < position_ + size) bytes.resize(position_ + size);
    std::memcpy(bytes.data() + position_, from, size);
    position_ += size;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }

  std::string bytes = {};

 private:
  std::size_t position_ = 0;
};

class ViewInput : public Imf::IStream {
 public:
  explicit ViewInput(std::string_view bytes) : IStream("memory"), bytes_(bytes) {}
  bool read(char* to, int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (count < 0 || position_ > bytes_.size() || bytes_.size() - position_ < size) {
      throw std::runtime_error(fmt::format("it ends after {} bytes", bytes_.size()));
    }
    std::memcpy(to, bytes_.data() + position_, size);
    position_ += size;
    return position_ < bytes_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = position; }

 private:
  std::string_view bytes_;
  std::size_t position_ = 0;
};

// OpenEXR wants one display window for all parts: `whole` holds the largest.
Imf::Header header_of(const ExrPart& part, const Imath::Box2i& whole) {
  Imf::Header header(whole, Imath::Box2i({0, 0}, {part.width - 1, part.height - 1}));
  header.setName(part.name);
  header.setType(Imf::SCANLINEIMAGE);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const ExrChannel& channel : part.channels) {
    header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
  }
  for (const auto& [name, value] : part.attributes) {
    header.insert(name, Imf::IntAttribute(value));
  }
  return header;
}

// OpenEXR asks for a mutable pointer also where it only reads.
Imf::Slice slice_of(const float* values, int width) {
  return Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(values)), sizeof(float),
                    sizeof(float) * static_cast<std::size_t>(width));
}

// A damaged header may announce any size. ZIP packs at most 1032 to 1 (deflate's limit), so a part
// that would unpack to more than that is refused before memory is asked for it.
void check_size(const Imf::Header& header, std::size_t file_size) {
  const Imath::Box2i& window = header.dataWindow();
  const double width = static_cast<double>(window.max.x) - window.min.x + 1;
  const double height = static_cast<double>(window.max.y) - window.min.y + 1;
  if (window.min.x != 0 || window.min.y != 0 || width < 1 || height < 1 ||
      width * height * sizeof(float) > 1032.0 * static_cast<double>(file_size)) {
    throw std::runtime_error(fmt::format("{} x {} pixels from ({}, {}) in a file of {} bytes",
                                         width, height, window.min.x, window.min.y, file_size));
  }
}

ExrPart read_part(Imf::MultiPartInputFile& input, int index, std::size_t file_size) {
  const Imf::Header& header = input.header(index);
  check_size(header, file_size);
  ExrPart part = {.name = header.hasName() ? header.name() : "",
                  .width = header.dataWindow().max.x + 1,
                  .height = header.dataWindow().max.y + 1};
  const auto count = static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height);
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    if (it.channel().type != Imf::FLOAT || it.channel().xSampling != 1 ||
        it.channel().ySampling != 1) {
      throw std::runtime_error(fmt::format("channel {} is not 32-bit float", it.name()));
    }
    part.channels.push_back({.name = it.name(), .values = std::vector<float>(count)});
  }
  Imf::FrameBuffer buffer;
  for (const ExrChannel& channel : part.channels) {
    buffer.insert(channel.name, slice_of(channel.values.data(), part.width));
  }
  for (auto it = header.begin(); it != header.end(); ++it) {
    const auto* value = dynamic_cast<const Imf::IntAttribute*>(&it.attribute());
    if (value != nullptr) part.attributes[it.name()] = value->value();
  }
  Imf::InputPart pixels(input, index);
  pixels.setFrameBuffer(buffer);
  pixels.readPixels(0, part.height - 1);
  return part;
}

void check_channel(const std::string& file, const ExrPart& part, const ExrChannel& channel,
                   bool may_be_negative) {
  const auto width = static_cast<std::size_t>(part.width);
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    const float value = channel.values[i];
    if (std::isfinite(value) && (may_be_negative || value >= 0)) continue;
    throw std::runtime_error(
        fmt::format("{}: part {}: pixel ({}, {}) channel {} = {}; expected a finite value{}", file,
                    part.name, i % width, i / width, channel.name, value,
                    may_be_negative ? "" : " >= 0"));
  }
}

}  // namespace

std::string exr_bytes(const std::vector<ExrPart>& parts) {
  assert(!parts.empty());
  Imath::Box2i whole;
  for (const ExrPart& part : parts) {
    whole.extendBy(Imath::V2i(0, 0));
    whole.extendBy(Imath::V2i(part.width - 1, part.height - 1));
  }
  std::vector<Imf::Header> headers;
  for (const ExrPart& part : parts) headers.push_back(header_of(part, whole));
  StringOutput stream;
  {  // the file's tables are written when it goes out of scope
    Imf::MultiPartOutputFile output(stream, headers.data(), static_cast<int>(headers.size()));
    for (std::size_t i = 0; i < parts.size(); ++i) {
      Imf::FrameBuffer buffer;
      for (const ExrChannel& channel : parts[i].channels) {
        assert(channel.values.size() == static_cast<std::size_t>(parts[i].width) *
                                            static_cast<std::size_t>(parts[i].height));
        buffer.insert(channel.name, slice_of(channel.values.data(), parts[i].width));
      }
      Imf::OutputPart pixels(output, static_cast<int>(i));
      pixels.setFrameBuffer(buffer);
      pixels.writePixels(parts[i].height);
    }
  }
  return std::move(stream.bytes);
}

std::vector<ExrPart> parse_exr(const std::string& file, std::string_view bytes) {
  std::vector<ExrPart> parts;
  std::string place = file;
  try {
    ViewInput stream(bytes);
    // No rebuilding of a damaged offset table: a file that is not whole is refused, not mended.
    Imf::MultiPartInputFile input(stream, Imf::globalThreadCount(), false);
    for (int i = 0; i < input.parts(); ++i) {
      if (input.header(i).hasName())
        place = fmt::format("{}: part {}", file, input.header(i).name());
      parts.push_back(read_part(input, i, bytes.size()));
    }
  } catch (const std::exception& error) {
    std::string why = error.what();
    for (char& c : why) {
      if (c == '\n') c = ' ';
    }
    throw std::runtime_error(
        fmt::format("{}: cannot be read: {}; expected a whole OpenEXR file", place, why));
  }
  return parts;
}

void check_radiances(const std::string& file, const ExrPart& part) {
  for (const ExrChannel& channel : part.channels) check_channel(file, part, channel, false);
}

void check_signed_values(const std::string& file, const ExrPart& part) {
  for (const ExrChannel& channel : part.channels) {
    check_channel(file, part, channel, !channel.name.ends_with(".variance"));
  }
}

}  // namespace pluvia
