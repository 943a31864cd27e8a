#include "io/store/durable_sync.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "base/error.h"

namespace tetfusion {

DurableSync::DurableSync(std::shared_ptr<ScratchFolder> folder, std::shared_ptr<Manifest> manifest)
    : folder_(std::move(folder)), manifest_(std::move(manifest)) {}

DurableSync::~DurableSync() { stop(); }

void DurableSync::commit(std::shared_ptr<Generation> generation, bool durable) {
  std::shared_ptr<Generation> dropped;  // its files go when the lock is open again
  const std::lock_guard lock(mutex_);
  generation->set_needed(true);
  if (newest_ != nullptr && newest_ != durable_) {
    newest_->set_needed(false);
    dropped = std::move(newest_);
  }
  newest_ = std::move(generation);
  if (durable) durable_ = newest_;
  start_worker();
}

// Where the system gives no more threads nothing becomes durable until it does: that is lost only
// with the machine's power.
void DurableSync::start_worker() {
  try {
    if (!worker_.joinable()) worker_ = std::thread([this] { work(); });
  } catch (const std::system_error&) {
    return;
  }
  changed_.notify_all();
}

void DurableSync::drop_spares() {
  const std::lock_guard lock(mutex_);
  drop_spares_ = true;
  start_worker();
}

void DurableSync::keep(std::shared_ptr<Generation> generation, bool durable) {
  const std::lock_guard lock(mutex_);
  generation->set_needed(true);
  kept_.push_back(std::move(generation));
  if (durable) durable_kept_ = kept_.size();
}

bool DurableSync::holds(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto is_it = [&](const std::shared_ptr<Generation>& g) {
    return g != nullptr && g->name() == name;
  };
  return is_it(newest_) || is_it(durable_) || std::any_of(kept_.begin(), kept_.end(), is_it);
}

bool DurableSync::empty() const {
  const std::lock_guard lock(mutex_);
  return newest_ == nullptr;
}

void DurableSync::drop_all() {
  stop();
  const std::lock_guard lock(mutex_);
  for (auto* generation : {&newest_, &durable_}) {
    if (*generation != nullptr) (*generation)->set_needed(false);
    generation->reset();
  }
  for (const auto& generation : kept_) generation->set_needed(false);
  kept_.clear();
  durable_kept_ = 0;
}

void DurableSync::stop() noexcept {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    changed_.notify_all();
  }
  if (worker_.joinable()) worker_.join();
}

void DurableSync::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    const auto is_behind = [&] { return newest_ != durable_ && !failed_; };
    changed_.wait(lock, [&] { return stop_ || drop_spares_ || is_behind(); });
    if (stop_) return;
    if (!is_behind()) {
      drop_spares_ = false;
      lock.unlock();
      folder_->trim_spares(true);
      lock.lock();
      continue;
    }
    std::shared_ptr<Generation> generation = newest_;
    lock.unlock();
    // Spares that the generation before this one had no use for.
    folder_->trim_spares(false);
    try {
      if (sync(*generation)) note_durable(generation);
    } catch (const std::exception& e) {
      folder_->remember_failure(e.what());
      lock.lock();
      failed_ = true;
      continue;
    }
    generation.reset();  // its files may go
    lock.lock();
  }
}

// It is durable; what was durable before goes.
void DurableSync::note_durable(const std::shared_ptr<Generation>& generation) {
  std::shared_ptr<Generation> dropped;
  {
    const std::lock_guard lock(mutex_);
    if (newest_ != generation) return;
    if (durable_ != nullptr) durable_->set_needed(false);
    dropped = std::exchange(durable_, generation);
  }
  manifest_->mark_durable(generation->name());
}

bool DurableSync::superseded(const Generation& generation) const {
  const std::lock_guard lock(mutex_);
  return stop_ || newest_.get() != &generation;
}

bool DurableSync::sync_files(const Generation& generation, const Generation& newest) {
  FileSystem& system = file_system();
  for (const Generation::File& entry : generation.files()) {
    if (superseded(newest)) return false;
    const std::string name = scratch_name(generation.name(), entry.source);
    const Descriptor file = folder_->open(name);
    if (retry([&] { return system.fsync(file.get()); }) != 0) {
      throw Error(ErrorCode::kIo, fmt::format("{}: cannot sync it: {}; see whether its disk fails",
                                              folder_->path_of(name), std::strerror(errno)));
    }
  }
  return true;
}

bool DurableSync::sync(const Generation& generation) {
  FileSystem& system = file_system();
  for (;;) {
    std::shared_ptr<Generation> kept;
    {
      const std::lock_guard lock(mutex_);
      if (durable_kept_ == kept_.size()) break;
      kept = kept_[durable_kept_];
    }
    if (!sync_files(*kept, generation)) return false;
    const std::lock_guard lock(mutex_);
    ++durable_kept_;
  }
  if (!sync_files(generation, generation)) return false;
  // Some network file systems cannot sync a folder.
  if (retry([&] { return system.fsync(folder_->fd()); }) != 0 && errno != EINVAL) {
    throw Error(ErrorCode::kIo,
                fmt::format("{}: cannot sync it: {}", folder_->path(), std::strerror(errno)));
  }
  if (const int error = manifest_->sync(); error != 0) {
    throw Error(ErrorCode::kIo, fmt::format("{}: cannot sync it: {}",
                                            folder_->path_of(kManifestName), std::strerror(error)));
  }
  return true;
}

}  // namespace tetfusion
