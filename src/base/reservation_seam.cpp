#include "base/reservation_seam.h"

#include <atomic>

namespace tetfusion {

namespace {

ReservationSeam usual_seam;
std::atomic<ReservationSeam*> current_seam{&usual_seam};

}  // namespace

bool ReservationSeam::refuses() { return false; }

ReservationSeam& reservation_seam() { return *current_seam.load(std::memory_order_acquire); }

ReservationSeam* replace_reservation_seam(ReservationSeam* other) {
  return current_seam.exchange(other != nullptr ? other : &usual_seam);
}

}  // namespace tetfusion
