#include "saltus/robots/model/contact_cone.hpp"

#include <utility>
#include <vector>

namespace saltus::robots {
namespace {

class ConeRows final : public FunctionBody {
 public:
  ConeRows(const ContactCone& cone, int inputs, int first)
      : FunctionBody(inputs, cone.rows()), A_(cone.A), first_(first) {
    std::vector<std::pair<int, int>> nonzeros;
    for (int r = 0; r < cone.rows(); ++r)
      for (int c = 0; c < 6; ++c)
        if (A_(r, c) != 0.0) nonzeros.emplace_back(r, first + c);
    jacobian_pattern_ = SparsityPattern::from_pairs(cone.rows(), inputs, std::move(nonzeros));
    hessian_pattern_ = SparsityPattern(inputs, inputs);
  }

  bool is_reentrant() const override { return true; }
  void value(const double* z, double* y) const override {
    const double* w = z + first_;
    for (int r = 0; r < outputs(); ++r) {
      const double force = A_(r, 0) * w[0] + (A_(r, 1) * w[1] + A_(r, 2) * w[2]);
      const double torque = A_(r, 3) * w[3] + (A_(r, 4) * w[4] + A_(r, 5) * w[5]);
      y[r] = force + torque;
    }
  }
  void jacobian(const double* z, double* y, double* entries) const override {
    value(z, y);
    jacobian_pattern_.for_each([&](int r, int c, int e) { entries[e] = A_(r, c - first_); });
  }
  void hessian(const double*, const double*, double*, Curvature) const override {}

 private:
  MatrixXd A_;
  int first_;
};

}  // namespace

Function cone_rows(const ContactCone& cone, const Arguments& sizes, int first) {
  return Function(
      std::unique_ptr<const FunctionBody>(std::make_unique<ConeRows>(cone, sizes.size(), first)));
}

}  // namespace saltus::robots
