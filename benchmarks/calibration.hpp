// Measures the present speed of the machine: a fixed amount of small dense algebra, so that times
// of different machines and hours can be compared.
#pragma once

namespace saltus::bench {

/// CPU time in microseconds of 16 products and 16 Cholesky factorisations of 16 x 16 matrices, the
/// median of some repetitions (a few milliseconds altogether).
double calibrate();

}  // namespace saltus::bench
