// Includes all core headers for a first program. Components that need SUNDIALS, Ipopt, DART or
// MuJoCo have separate headers.
#pragma once

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/simulate.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/model/derivative_check.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/sequences/search.hpp"
#include "saltus/simulation/closed_loop.hpp"
#include "saltus/solve/check.hpp"
#include "saltus/solve/explain.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/replay.hpp"
#include "saltus/verify/verify.hpp"
