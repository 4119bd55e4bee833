#include "benchmarks/point_shift.hpp"

#include <algorithm>

namespace saltus::bench {
namespace {

// Position in the stage and shape identify a group.
void shift_groups(const qp::Stage& old, const qp::StagePoint::AtStage& source, const qp::Stage& s,
                  qp::StagePoint::AtStage& out) {
  for (std::size_t g = 0; g < s.groups.size(); ++g) {
    const bool known = g < old.groups.size() && old.groups[g].rows == s.groups[g].rows &&
                       old.groups[g].columns.size() == s.groups[g].columns.size();
    if (known)
      out.group[g].head(s.groups[g].rows) = source.group[g].head(s.groups[g].rows);
    else
      out.group[g].setZero();
  }
}

}  // namespace

void shift_by_one_stage(const qp::StageQp& from, const qp::StagePoint& solution,
                        const qp::StageQp& to, const qp::StagePoint& guess, qp::StagePoint& out) {
  const int N = to.intervals();
  for (int k = 0; k <= N; ++k) {
    const qp::Stage& s = to.stages[k];
    qp::StagePoint::AtStage& p = out.stages[k];
    // The last stage of a program has no inputs: the previous one is unchanged.
    const int earlier = k >= N - 1 ? k : k + 1;
    const qp::Stage& old = from.stages[earlier];
    const qp::StagePoint::AtStage& source = solution.stages[earlier];

    p.x.head(s.nx) = solution.stages[std::min(k + 1, N)].x.head(s.nx);
    p.x_bound.head(s.nx) = source.x_bound.head(s.nx);
    if (old.nu == s.nu) {
      p.u.head(s.nu) = source.u.head(s.nu);
      p.u_bound.head(s.nu) = source.u_bound.head(s.nu);
    } else {
      p.u.head(s.nu) = guess.stages[k].u.head(s.nu);
      p.u_bound.head(s.nu).setZero();
    }
    if (k < N) p.costate = source.costate;
    shift_groups(old, source, s, p);
  }
  if (to.fixed_start) out.stages[0].x.head(to.stages[0].nx) = to.start.head(to.stages[0].nx);
  if (N == 0) return;
  const qp::Stage& s = to.stages[N - 1];
  const qp::StagePoint::AtStage& p = out.stages[N - 1];
  for (int i = 0; i < to.stages[N].nx; ++i) {
    double next = s.b[i];
    for (int j = 0; j < s.nx; ++j) next += s.A(i, j) * p.x[j];
    for (int j = 0; j < s.nu; ++j) next += s.B(i, j) * p.u[j];
    out.stages[N].x[i] = next;
  }
}

}  // namespace saltus::bench
