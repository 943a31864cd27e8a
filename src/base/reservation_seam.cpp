#include "base/reservation_seam.h"

#include <atomic>

namespace tetfusion {

namespace {

ReservationSeam usual;
std::atomic<ReservationSeam*> current{&usual};

}  // namespace

bool ReservationSeam::refuses() { return false; }

ReservationSeam& reservation_seam() { return *current.load(std::memory_order_acquire); }

ReservationSeam* replace_reservation_seam(ReservationSeam* other) {
  return current.exchange(other != nullptr ? other : &usual);
}

}  // namespace tetfusion
