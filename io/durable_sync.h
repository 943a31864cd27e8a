// Makes committed generations durable behind the run's back, the newest first.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "io/manifest.h"
#include "io/piece_store_disk.h"
#include "io/scratch_folder.h"

namespace tetfusion {

// Holds the generations that a resumed run may need: the newest committed one and the newest
// durable one. The others go. Failures are left in the folder (ScratchFolder::throw_failure).
// Thread-safe.
class DurableSync {
 public:
  DurableSync(std::shared_ptr<ScratchFolder> folder, std::shared_ptr<Manifest> manifest);
  ~DurableSync();  // gives up what is not finished; the generations stay on the disk

  void commit(std::shared_ptr<Generation> generation, bool durable = false);
  bool holds(const std::string& name) const;
  bool empty() const;
  // Stops for good; nothing is needed any more.
  void drop_all();

 private:
  void work();
  bool sync(const Generation& generation);  // false: failed, or given up
  void keep(const std::shared_ptr<Generation>& generation);
  bool superseded(const Generation& generation) const;
  void stop() noexcept;

  std::shared_ptr<ScratchFolder> folder_;
  std::shared_ptr<Manifest> manifest_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<Generation> newest_;
  std::shared_ptr<Generation> durable_;
  bool failed_ = false;
  bool stop_ = false;
  std::thread worker_;  // from the first commit on
};

}  // namespace tetfusion
