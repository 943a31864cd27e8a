// Objects that keep their memory from one use to the next.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace tetfusion {

// Objects that whoever works on a part borrows, so that their memory is not asked for anew, and
// cleared by the system, for each. Thread-safe.
template <class T>
class Pool {
 public:
  class Loan {
   public:
    explicit Loan(Pool* pool) : pool_(pool) {
      const std::lock_guard lock(pool->mutex_);
      if (pool->free_.empty()) {
        pool->free_.reserve(++pool->objects_);  // so that giving it back cannot fail
        object_ = std::make_unique<T>();
      } else {
        object_ = std::move(pool->free_.back());
        pool->free_.pop_back();
      }
    }
    ~Loan() {
      const std::lock_guard lock(pool_->mutex_);
      pool_->free_.push_back(std::move(object_));
    }
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    T* operator->() { return object_.get(); }
    T& operator*() { return *object_; }

   private:
    Pool* pool_;
    std::unique_ptr<T> object_;
  };
  Loan borrow() { return Loan(this); }

 private:
  std::mutex mutex_;
  std::size_t objects_ = 0;  // lent ones, too
  std::vector<std::unique_ptr<T>> free_;
};

}  // namespace tetfusion
