// A file that appears under its name only when it is whole.
//
// A regular file is written without a name in the folder of its target, and synced; commit() gives
// it a temporary name and then the target's, in one step, as a name cannot replace another one. So
// a process that is killed leaves nothing. Where the file system knows no files without names it
// has the temporary one from the start. Without commit() the target is what it was. Standard
// output ("-"), devices and pipes cannot be replaced: bytes go straight to them, or, where the
// writer has to go back and patch, by way of a nameless temporary file that finish() copies.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "io/files/mapped_file.h"

namespace tetfusion {

// Throws Error(kIo) if an OutputFile of that name could not be made: its folder is missing or not
// writable, the target is a folder or read-only. Creates nothing; meant to be called before hours
// of work.
void check_output_path(const std::string& path);

// Is that a temporary name? (Without the folder.)
bool is_temporary_name(std::string_view name);

// Not thread-safe. Every function throws Error(kIo) when writing fails; the file can then only be
// destroyed. A caller that breaks these rules gets std::logic_error.
class OutputFile {
 public:
  enum class Access {
    kAppend,  // append() only
    kPatch    // overwrite() too
  };
  static constexpr std::size_t kBufferBytes = std::size_t{512} << 10;

  explicit OutputFile(const std::string& path, Access access = Access::kAppend);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  // Says how long the file will be, or at least be: space is set aside for it where the file system
  // can, so that a disk too small fails here. Call before the first append().
  void expect(std::uint64_t bytes);
  void append(const void* data, std::size_t bytes);
  // Replaces bytes that were appended before. Needs Access::kPatch.
  void overwrite(std::uint64_t offset, const void* data, std::size_t bytes);
  std::uint64_t size() const { return size_; }  // bytes appended so far

  // A regular file may also be written out of order: leave_room() appends bytes that place() fills
  // later, each byte once, from several threads at once. Returns where the room begins.
  bool can_leave_room() const { return !target_.empty(); }
  std::uint64_t leave_room(std::uint64_t bytes);
  void place(std::uint64_t offset, const void* data, std::size_t bytes) const;

  // What was appended so far, mapped; to look at before, or instead of, commit(). Only of a regular
  // file.
  MappedFile read_back();

  // Where the bytes so far can be read before commit(), for as long as this object lives. Not of a
  // stream that is written without a spool: that takes Access::kPatch.
  std::string path_to_read();

  // All of commit() that may take long, or find no room: makes the file durable, or gives a stream
  // its bytes. Where several files belong together, each is finished before the first gets its
  // name. Nothing but commit() may follow.
  void finish();

  // Makes the file durable and gives it its name. Call once, last. Where other files are to have
  // their names first `before_name` gives them these: it is called when little can fail any more,
  // and what it throws leaves the target as it was.
  void commit(const std::function<void()>& before_name = {});

 private:
  void open_temporary();
  bool open_without_name();
  template <class F>
  std::string take_temporary_name(F make) const;
  void open_spool();
  void flush();
  void write_behind(std::uint64_t bytes) const;
  void write_out(const void* data, std::size_t bytes);
  void copy_spool();
  void close(int* fd);
  [[noreturn]] void fail(const char* what, int error) const;

  std::string path_;       // as the user gave it, for messages
  std::string target_;     // links followed; empty when there is nothing to rename
  std::string temporary_;  // empty when nothing has to be unlinked
  bool nameless_ = false;  // until commit()
  bool spooled_ = false;   // the bytes lie in a nameless file until finish()
  bool finished_ = false;
  int fd_ = -1;
  int stream_ = -1;  // where a spool is copied to
  std::unique_ptr<std::byte[]> buffer_;
  std::size_t buffered_ = 0;
  std::uint64_t size_ = 0;
  std::uint64_t written_ = 0;                     // size_ without what is buffered
  std::uint64_t expected_ = 0;                    // 0: not known
  mutable std::atomic<std::uint64_t> behind_{0};  // written since the disk was last told to begin
};

}  // namespace tetfusion
