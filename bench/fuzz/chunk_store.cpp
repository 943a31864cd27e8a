#include <sys/mman.h>

#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/error.h"
#include "driver/checkpoint.h"
#include "fuzz/read_all.h"
#include "fuzz/targets.h"
#include "io/files/checksum.h"
#include "io/files/file_system.h"
#include "io/store/manifest.h"
#include "io/store/section_file.h"

namespace tetfusion::fuzz {

namespace {

using Bytes = std::vector<std::uint8_t>;

// io/FORMAT.md.
constexpr std::size_t kHeaderBytes = 64;
constexpr std::size_t kSectionBytes = 32;
constexpr std::size_t kManifestHead = 16;

template <class T>
T get(const Bytes& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

void put(Bytes* bytes, std::size_t at, std::uint64_t value) {
  std::memcpy(bytes->data() + at, &value, sizeof value);
}

std::uint64_t sum(const Bytes& bytes, std::size_t from, std::size_t count, std::uint64_t seed = 0) {
  return checksum(std::as_bytes(std::span(bytes).subspan(from, count)), seed);
}

void seal_sections(Bytes* bytes) {
  if (bytes->size() < kHeaderBytes + 8) return;
  put(bytes, 16, bytes->size());
  const std::size_t sections = get<std::uint32_t>(*bytes, 36);
  if (sections > (bytes->size() - kHeaderBytes - 8) / kSectionBytes) return;
  for (std::size_t i = 0; i < sections; ++i) {
    const std::size_t at = kHeaderBytes + i * kSectionBytes;
    const auto offset = get<std::uint64_t>(*bytes, at);
    const auto count = get<std::uint64_t>(*bytes, at + 8);
    if (offset > bytes->size() || count > bytes->size() - offset) continue;
    put(bytes, at + 16, sum(*bytes, offset, count));
  }
  const std::size_t end = kHeaderBytes + sections * kSectionBytes;
  put(bytes, end, sum(*bytes, 0, end));
}

void seal_manifest(Bytes* bytes) {
  std::size_t at = kManifestHead;
  while (bytes->size() >= at + 16) {
    const std::uint64_t record = 8 + std::uint64_t{get<std::uint32_t>(*bytes, at)};
    if (bytes->size() - at < record + 8) return;
    put(bytes, at + record, sum(*bytes, at, record, at));
    at += record + 8;
  }
}

Descriptor file_of(const Bytes& bytes) {
  Descriptor fd(::memfd_create("input", MFD_CLOEXEC));
  if (!fd || pwrite_all(fd.get(), bytes.data(), bytes.size(), 0) != 0) {
    throw std::runtime_error("no file in memory can be made");
  }
  return fd;
}

void read_section_file(const Bytes& bytes) try {
  const Descriptor fd = file_of(bytes);
  const SectionTable table = read_sections(fd.get(), "input.pieces");
  for (const Section& s : table.sections) {
    check_section("input.pieces", s, std::as_bytes(std::span(bytes)).subspan(s.offset, s.bytes));
  }
} catch (const Error&) {
}

// What is whole of it is kept, and what is added to it comes back.
void read_manifest(const Bytes& bytes) {
  Descriptor fd = file_of(bytes);
  const Descriptor again(file_system().duplicate(fd.get()));
  Manifest manifest(std::move(fd), "manifest");
  if (manifest.blank()) manifest.start("fingerprint");
  const std::size_t before = manifest.commits().size();
  manifest.commit({"added", 1, 2, false});
  manifest.mark_durable("added");
  const Manifest reread(Descriptor(file_system().duplicate(again.get())), "manifest");
  if (reread.fingerprint() != manifest.fingerprint() || reread.commits().size() != before + 1 ||
      reread.commits().back().name != "added" || !reread.commits().back().durable) {
    throw std::logic_error("a manifest that was added to is another one");
  }
}

template <class Real>
void read_state(Input input) try {
  RunState<Real> state;
  load(std::as_bytes(input), &state);
  // What was believed is what is there.
  if (save(state).size() > input.size())
    throw std::logic_error("a state of more bytes than it was read from");
} catch (const Error&) {
}

void read_one(const Bytes& bytes, bool manifest) {
  if (manifest) {
    read_manifest(bytes);
  } else {
    read_section_file(bytes);
  }
}

}  // namespace

void read_chunk_store(Input input) {
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  const bool manifest = text.starts_with("TFMANIFE");
  if (!manifest && !text.starts_with("TFPIECES")) {
    read_state<float>(input);
    read_state<double>(input);
    return;
  }
  Bytes bytes(input.begin(), input.end());
  read_one(bytes, manifest);
  (manifest ? seal_manifest : seal_sections)(&bytes);
  read_one(bytes, manifest);
}

}  // namespace tetfusion::fuzz
