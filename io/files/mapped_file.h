// A whole file, mapped for reading: the one place where this room's readers make system calls.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace tetfusion {

// Holds the file open and mapped from open() to destruction. Safe to read from several threads.
// When another program shortens the file meanwhile, or the disk fails, what is missing reads as
// zeros, and check() says so.
class MappedFile {
 public:
  // Maps a regular file; anything that can only be read once (a pipe, a terminal) is spooled first.
  // Throws Error(kIo) when there is no such file, it may not be read or is a folder, and
  // Error(kBadInput) when it is empty.
  static MappedFile open(const std::string& path, const std::string& spool_folder = {},
                         const std::atomic<bool>* cancelled = nullptr);

  // Copies all that can be read from `fd` to a nameless file and maps that. `name` is what messages
  // call it. The copy lies on the disk of `folder`, which need not exist as long as the one that is
  // to hold it does; without one in $TMPDIR or /tmp. Does not close `fd`.
  // Throws Error(kInterrupted) when a signal comes while it waits, or `cancelled` becomes true.
  static MappedFile spool(int fd, const std::string& name, const std::string& folder = {},
                          const std::atomic<bool>* cancelled = nullptr);

  // Maps a regular file that is open, and takes the descriptor. Throws as open() does.
  static MappedFile of_descriptor(int fd, const std::string& name);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  int fd() const { return fd_; }
  // checksum() of all bytes, where they were spooled.
  std::optional<std::uint64_t> spooled_checksum() const { return spooled_checksum_; }
  std::span<const std::byte> bytes() const { return {data_, size_}; }

  // Throws Error(kIo), naming the byte, when a page of the file could not be read. To be called
  // after reading, and before an error about the contents is believed.
  void check() const;

  // Hints, rounded outwards to whole pages; they change nothing but speed and resident memory, also
  // where another thread is reading the same pages.
  void will_need(std::uint64_t offset, std::uint64_t count) const;  // start reading ahead
  void populate(std::uint64_t offset, std::uint64_t count) const;  // map the pages now, in one call
  // Takes the pages out of this process. The second one takes their neighbours, too: where one page
  // is touched, the system maps what it has in one piece, up to 2 MiB.
  void dont_need(std::uint64_t offset, std::uint64_t count) const;
  void dont_need_around(std::uint64_t offset, std::uint64_t count) const;

 private:
  MappedFile(std::string path, int fd, std::uint64_t size);  // takes `fd`
  void advise(std::uint64_t offset, std::uint64_t count, int advice) const;

  std::string path_;
  int fd_ = -1;
  int guard_ = -1;  // in the table of mappings that the fault handler knows
  std::size_t size_ = 0;
  const std::byte* data_ = nullptr;
  std::optional<std::uint64_t> spooled_checksum_;
};

}  // namespace tetfusion
