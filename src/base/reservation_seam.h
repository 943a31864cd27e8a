// The seam between a memory budget and those who reserve: tests refuse a reservation of their
// choice.
#pragma once

namespace tetfusion {

// This class refuses none; tests derive from it. Thread-safe.
class ReservationSeam {
 public:
  virtual ~ReservationSeam() = default;

  // Asked once for each reservation, and for each that grows.
  virtual bool refuses();
};

ReservationSeam& reservation_seam();

// For tests: puts another one in its place and returns the one before; nullptr means the usual one.
// Not while work is under way.
ReservationSeam* replace_reservation_seam(ReservationSeam* other);

}  // namespace tetfusion
