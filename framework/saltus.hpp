// Everything of the core that a first program needs; includes only. What needs SUNDIALS, Ipopt,
// DART or MuJoCo has headers of its own.
#pragma once

#include "saltus/core/error.hpp"
#include "saltus/integrators/hybrid_simulation.hpp"
#include "saltus/integrators/implicit_midpoint.hpp"
#include "saltus/integrators/implicit_runge_kutta.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/simulate.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/model/derivative_check.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/sequences/search.hpp"
#include "saltus/simulation/closed_loop.hpp"
#include "saltus/solve/homotopy.hpp"
#include "saltus/solve/several_starts.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/sqp.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/replay.hpp"
