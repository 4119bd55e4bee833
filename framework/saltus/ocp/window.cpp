#include "saltus/ocp/schedule.hpp"

namespace saltus {

Instant::Instant(const Instant& other) = default;
Instant::Instant(Instant&& other) noexcept = default;
Instant& Instant::operator=(const Instant& other) = default;
Instant& Instant::operator=(Instant&& other) noexcept = default;
Instant::~Instant() = default;

}  // namespace saltus
