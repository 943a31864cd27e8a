// Makes committed generations durable behind the run's back, the newest first.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "io/store/manifest.h"
#include "io/store/piece_store_disk.h"
#include "io/store/scratch_folder.h"

namespace tetfusion {

// Holds the generations that a resumed run may need: the newest committed one, the newest durable
// one, and those that are kept. The others go. Failures are left in the folder
// (ScratchFolder::throw_failure). Thread-safe.
class DurableSync {
 public:
  DurableSync(std::shared_ptr<ScratchFolder> folder, std::shared_ptr<Manifest> manifest);
  ~DurableSync();  // gives up what is not finished; the generations stay on the disk

  // Those that are kept before are made durable first.
  void commit(std::shared_ptr<Generation> generation, bool durable = false);
  void keep(std::shared_ptr<Generation> generation, bool durable = false);
  void drop_spares();  // the folder's, when nothing is left to sync
  bool holds(const std::string& name) const;
  bool empty() const;
  // Stops for good; nothing is needed any more.
  void drop_all();

 private:
  void start_worker();
  void work();
  bool sync(const Generation& generation);  // false: given up
  // The files of `generation`, for the sake of `newest`. False: given up.
  bool sync_files(const Generation& generation, const Generation& newest);
  void note_durable(const std::shared_ptr<Generation>& generation);
  bool superseded(const Generation& generation) const;
  void stop() noexcept;

  std::shared_ptr<ScratchFolder> folder_;
  std::shared_ptr<Manifest> manifest_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<Generation> newest_;
  std::shared_ptr<Generation> durable_;
  std::vector<std::shared_ptr<Generation>> kept_;
  std::size_t durable_kept_ = 0;  // of these, the first ones
  bool failed_ = false;
  bool stop_ = false;
  bool drop_spares_ = false;
  std::thread worker_;  // from the first call on that has work for it
};

}  // namespace tetfusion
