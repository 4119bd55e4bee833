#include "saltus/model/integrator.hpp"

namespace saltus {

const char* describe(HybridEvent::Kind kind) {
  switch (kind) {
    case HybridEvent::Kind::crosses:
      return "crosses";
    case HybridEvent::Kind::jumps:
      return "jumps";
    case HybridEvent::Kind::slides:
      return "slides";
    case HybridEvent::Kind::leaves:
      return "leaves";
  }
  return "unknown kind of event";
}

}  // namespace saltus
