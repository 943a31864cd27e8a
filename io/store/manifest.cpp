#include "io/store/manifest.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "io/files/checksum.h"

namespace tetfusion {

namespace {

constexpr std::uint32_t kFingerprint = 1;
constexpr std::uint32_t kCommit = 2;
constexpr std::uint32_t kDurable = 3;
constexpr std::uint32_t kKept = 4;
constexpr std::uint32_t kForgotten = 5;
constexpr std::uint32_t kEnd = 6;

// More than any run writes: a fingerprint, and some records of a hundred bytes a round.
constexpr std::uint64_t kMaxBytes = std::uint64_t{64} << 20;

struct ManifestHead {
  std::array<char, 8> magic = {'T', 'F', 'M', 'A', 'N', 'I', 'F', 'E'};
  std::uint32_t byte_order = 0x01020304;
  std::uint32_t version = 1;
  friend bool operator==(const ManifestHead&, const ManifestHead&) = default;
};
static_assert(sizeof(ManifestHead) == 16);

struct RecordHead {
  std::uint32_t bytes = 0;
  std::uint32_t kind = 0;
};

template <class T>
void put(std::vector<std::byte>* out, const T& value) {
  const auto bytes = std::as_bytes(std::span(&value, 1));
  out->insert(out->end(), bytes.begin(), bytes.end());
}

void put_text(std::vector<std::byte>* out, std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  out->insert(out->end(), bytes.begin(), bytes.end());
}

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <class T>
T get(std::span<const std::byte> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

std::vector<std::byte> payload_of(std::uint64_t files, std::uint64_t digest,
                                  std::string_view name) {
  std::vector<std::byte> payload;
  put(&payload, files);
  put(&payload, digest);
  put_text(&payload, name);
  return payload;
}

}  // namespace

Manifest::Manifest(Descriptor file, std::string path)
    : file_(std::move(file)), path_(std::move(path)) {
  load();
}

void Manifest::load() {
  struct stat status {};
  if (file_system().fstat(file_.get(), &status) != 0) fail("look at", 0, errno);
  file_bytes_ = static_cast<std::uint64_t>(status.st_size);
  if (file_bytes_ < sizeof(ManifestHead) || file_bytes_ > kMaxBytes) return;
  std::vector<std::byte> all(file_bytes_);
  const int error = pread_all(file_.get(), all.data(), all.size(), 0);
  if (error == kEndOfFile) return;
  if (error != 0) fail("read", 0, error);
  if (get<ManifestHead>(all, 0) != ManifestHead{}) return;
  std::uint64_t at = sizeof(ManifestHead);
  for (;;) {
    const std::uint64_t left = all.size() - at;
    if (left < sizeof(RecordHead)) break;
    const auto head = get<RecordHead>(all, at);
    const std::uint64_t bytes = sizeof(RecordHead) + std::uint64_t{head.bytes};
    if (left < bytes + sizeof(std::uint64_t)) break;
    const auto record = std::span<const std::byte>(all).subspan(at, bytes);
    if (checksum(record, at) != get<std::uint64_t>(all, at + bytes)) break;
    if (!take(head.kind, record.subspan(sizeof(RecordHead)))) break;
    at += bytes + sizeof(std::uint64_t);
  }
  end_ = at;
  has_tail_ = at < file_bytes_;
}

bool Manifest::take(std::uint32_t kind, std::span<const std::byte> payload) {
  if (blank_ != (kind == kFingerprint)) return false;
  if (kind == kFingerprint) {
    fingerprint_ = text_of(payload);
    blank_ = false;
    return true;
  }
  if (kind == kCommit || kind == kKept) {
    constexpr std::size_t kNumbers = 2 * sizeof(std::uint64_t);
    if (payload.size() < kNumbers) return false;
    const std::string name = text_of(payload.subspan(kNumbers));
    const auto files = get<std::uint64_t>(payload, 0);
    const auto digest = get<std::uint64_t>(payload, sizeof(std::uint64_t));
    if (kind == kCommit) {
      commits_.push_back({name, files, digest, false, kept_});
    } else {
      std::erase_if(kept_, [&](const KeptGeneration& k) { return k.name == name; });
      kept_.push_back({name, files, digest});
    }
    return true;
  }
  if (kind == kEnd) {
    commits_.clear();
    kept_.clear();
    return true;
  }
  const std::string name = text_of(payload);
  if (kind == kForgotten) {
    std::erase_if(kept_, [&](const KeptGeneration& k) { return k.name == name; });
    return true;
  }
  if (kind != kDurable) return false;
  for (auto commit = commits_.rbegin(); commit != commits_.rend(); ++commit) {
    if (commit->name != name) continue;
    commit->durable = true;
    break;
  }
  return true;
}

void Manifest::start(const std::string& fingerprint) {
  if (retry([&] { return file_system().ftruncate(file_.get(), 0); }) != 0) fail("write", 0, errno);
  const ManifestHead head;
  const int error = pwrite_all(file_.get(), &head, sizeof(head), 0);
  if (error != 0) fail("write", 0, error);
  end_ = sizeof(head);
  has_tail_ = false;
  commits_.clear();
  kept_.clear();
  append(kFingerprint, std::as_bytes(std::span(fingerprint)));
  fingerprint_ = fingerprint;
  blank_ = false;
}

void Manifest::keep(const KeptGeneration& generation) {
  append(kKept, payload_of(generation.files, generation.digest, generation.name));
}

void Manifest::forget(std::string_view name) {
  append(kForgotten, std::as_bytes(std::span(name)));
}

void Manifest::commit(const Commit& commit) {
  append(kCommit, payload_of(commit.files, commit.digest, commit.name));
}

void Manifest::mark_durable(std::string_view name) {
  append(kDurable, std::as_bytes(std::span(name)));
}

void Manifest::end() { append(kEnd, {}); }

int Manifest::sync() {
  return retry([&] { return file_system().fsync(file_.get()); }) == 0 ? 0 : errno;
}

void Manifest::append(std::uint32_t kind, std::span<const std::byte> payload) {
  const std::lock_guard lock(mutex_);
  // A whole record may stand behind the one that is not: it must not come back to life.
  if (has_tail_) {
    const auto end = static_cast<off_t>(end_);
    if (retry([&] { return file_system().ftruncate(file_.get(), end); }) != 0) {
      fail("shorten", end_, errno);
    }
    has_tail_ = false;
  }
  std::vector<std::byte> record;
  put(&record, RecordHead{static_cast<std::uint32_t>(payload.size()), kind});
  record.insert(record.end(), payload.begin(), payload.end());
  put(&record, checksum(record, end_));
  const int error = pwrite_all(file_.get(), record.data(), record.size(), end_);
  if (error != 0) fail("write", end_, error);
  end_ += record.size();
}

void Manifest::fail(const char* what, std::uint64_t at, int error) const {
  throw Error(ErrorCode::kIo,
              fmt::format("{}: cannot {} it at byte {}: {}", path_, what, at, strerror(error)));
}

}  // namespace tetfusion
