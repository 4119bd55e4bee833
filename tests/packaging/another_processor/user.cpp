#include <saltus/core/types.hpp>

saltus::VectorXd ten() { return saltus::VectorXd::Zero(10); }
