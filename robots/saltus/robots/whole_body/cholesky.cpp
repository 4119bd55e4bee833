#include "saltus/robots/whole_body/cholesky.hpp"

namespace saltus::robots {

template <int n>
void Cholesky<n>::compute(const Mat<double, n, n>& A) {
  factor_.compute(A);
}

template <int n>
void Cholesky<n>::solve_in_place(Eigen::Ref<MatrixXd> B) const {
  factor_.solveInPlace(B);
}

template <int n>
void Cholesky<n>::solve_in_place(Vec<double, n>& b) const {
  factor_.solveInPlace(b);
}

template class Cholesky<6>;
template class Cholesky<Eigen::Dynamic>;

}  // namespace saltus::robots
