// Where a long run keeps its generations of pieces: in memory, or in a folder of its own from which
// a run that was killed goes on.
//
// The folder holds a manifest, appended to and never rewritten, and the files of the generations
// that are still needed. Nothing in it is trusted before its length and checksum have been
// compared.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/vector.h"
#include "io/store/piece_store.h"

namespace tetfusion {

// What a committed generation left: its pieces, sealed, and the state that was committed with it;
// and what was kept before that, by name.
struct Checkpoint {
  std::string generation;
  std::unique_ptr<PieceStore> pieces;
  Vector<std::byte> state;
  std::map<std::string, std::unique_ptr<PieceStore>> kept;

  // Out of `kept`. Throws Error(kIo) where it is not there, with `what` it has.
  std::unique_ptr<PieceStore> take_kept(const std::string& name, const char* what);
};

class Scratch {
 public:
  virtual ~Scratch() = default;

  // Begins a generation. `name` is of [a-z0-9-], and not in use. Destroying the store of a
  // generation that was not committed removes its files.
  virtual std::unique_ptr<PieceStore> begin(const std::string& name) = 0;

  // From here on a resumed run begins with this generation, which is sealed, and this state.
  // Returns at once: its files are synced behind the run's back, and what is older goes when they
  // are durable, or when a still newer one is committed first. A process that is killed loses
  // nothing that was committed; a machine that loses its power at most what was not durable yet.
  // Throws Error(kIo), also for what has failed behind the run's back since.
  virtual void commit(const std::string& name, std::span<const std::byte> state) = 0;

  // This generation, which is sealed, belongs to all that is committed from here on: it stays until
  // remove(), whoever destroys its store. Throws what commit() throws.
  virtual void keep(const std::string& name) = 0;

  // Throws Error(kIo) for what has failed behind the run's back, or was lost of pieces while they
  // were used. To be called before a result that was made of them gets its name.
  virtual void check() const = 0;

  // Takes back what an interrupted run left: the latest committed generation that is whole. Nothing
  // when there is none. Call once, first.
  virtual std::optional<Checkpoint> resume() = 0;

  // No generation follows: what is kept to be overwritten goes, behind the run's back.
  virtual void drop_spares() = 0;

  // The job is done, or cannot be resumed: removes the folder and all in it that is ours.
  virtual void remove() = 0;

  virtual std::uint64_t peak_bytes() const = 0;  // the most that all generations took at once
};

std::unique_ptr<Scratch> memory_scratch();

struct ScratchOptions {
  std::string folder;       // made if it is not there; its parent must be
  std::string fingerprint;  // of the program, the options and the input: what the result depends on
  bool resume = false;      // go on with what is there, if it has the same fingerprint
  std::uint64_t expected_bytes = 0;  // about what the run will need at most; 0: not known
};

// Throws Error(kUsage) when the folder holds another run's work (resume: of another fingerprint,
// naming what differs; else: any, saying to give --resume or to remove it) or things that are not
// ours, or when another process is using it; Error(kIo) when it cannot be made, or the disk has
// less room than expected_bytes (saying how much is needed and how much is there). Files are
// private (folder 0700, files 0600, O_EXCL), no link is followed.
std::unique_ptr<Scratch> disk_scratch(const ScratchOptions& options);

// For whoever only asks: throws what disk_scratch() would, as far as that can be told without
// making or changing anything. No other process can take the folder in the meantime.
void check_disk_scratch(const ScratchOptions& options);

// For jobs that nobody resumes, in folders of temporary_name() in `parent`: removes those that a
// killed process has left there, if they have that fingerprint and have not changed for a minute
// (younger ones may be about to be locked). All else stays, also what cannot be looked at.
void remove_dead_scratch(const std::string& parent, const std::string& fingerprint) noexcept;

// For a run that does not need it: throws Error(kUsage) where disk_scratch() would, as something
// else lies in the folder. It need not be there.
void check_scratch_folder(const std::string& path);

}  // namespace tetfusion
