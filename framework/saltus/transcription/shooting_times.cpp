// Times of ShootingProgram: a known part plus coefficients of the free durations.
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

using namespace shooting;

double ShootingProgram::known_start(int phase) const {
  double t = layout_.start_time() < 0 ? data_.start_time : 0.0;
  for (int i = 0; i < phase; ++i)
    if (layout_.duration(i) < 0) t += grid_.reference_duration(i);
  return t;
}

std::vector<VariableCoefficient> ShootingProgram::start_coefficients(int phase) const {
  std::vector<VariableCoefficient> coefficients = duration_coefficients(phase);
  if (layout_.start_time() >= 0) coefficients.push_back({layout_.start_time(), 1.0});
  return coefficients;
}

// Coefficients of the free durations among the first phases.
std::vector<VariableCoefficient> ShootingProgram::duration_coefficients(int phase) const {
  std::vector<VariableCoefficient> coefficients;
  for (int i = 0; i < phase; ++i)
    if (layout_.duration(i) >= 0)
      coefficients.push_back({layout_.duration(i), problem_.phases()[i].nominal_duration});
  return coefficients;
}

std::vector<VariableCoefficient> ShootingProgram::offset_coefficients(int phase,
                                                                      double slope) const {
  if (layout_.duration(phase) < 0 || slope == 0.0) return {};
  return {{layout_.duration(phase), slope * problem_.phases()[phase].nominal_duration}};
}

double ShootingProgram::known_time(const GridPoint& point) const {
  const double start = known_start(point.phase);
  if (point.node < grid_.intervals(point.phase))
    return start + grid_.interval(point.phase, point.node).offset0;
  const bool is_free = layout_.duration(point.phase) >= 0;
  return start + (is_free ? 0.0 : grid_.reference_duration(point.phase));
}

std::vector<VariableCoefficient> ShootingProgram::time_coefficients(const GridPoint& point) const {
  std::vector<VariableCoefficient> coefficients = start_coefficients(point.phase);
  const double slope = point.node < grid_.intervals(point.phase)
                           ? grid_.interval(point.phase, point.node).offset1
                           : 1.0;
  for (const VariableCoefficient& s : offset_coefficients(point.phase, slope))
    coefficients.push_back(s);
  return coefficients;
}

double ShootingProgram::interval_length(int phase, int k) const {
  return grid_.interval(phase, k).length(grid_.reference_duration(phase));
}

double ShootingProgram::duration_of(int phase, const VectorXd* w) const {
  if (layout_.duration(phase) < 0 || w == nullptr) return grid_.reference_duration(phase);
  return (*w)[layout_.duration(phase)] * problem_.phases()[phase].nominal_duration;
}

double ShootingProgram::start_of(int phase, const VectorXd* w) const {
  const bool is_decided = layout_.start_time() >= 0 && w != nullptr;
  double t = is_decided ? (*w)[layout_.start_time()] : data_.start_time;
  for (int i = 0; i < phase; ++i) t += duration_of(i, w);
  return t;
}

double ShootingProgram::time_of(const GridPoint& point, const VectorXd* w) const {
  const double T = duration_of(point.phase, w);
  const double start = start_of(point.phase, w);
  if (point.node == grid_.intervals(point.phase)) return start + T;
  return start + grid_.interval(point.phase, point.node).offset(T);
}

VectorXd ShootingProgram::parameters_of(int phase, const VectorXd* w) const {
  VectorXd p = data_.parameters[phase];
  if (w != nullptr)
    for (int i = 0; i < p.size(); ++i)
      if (layout_.parameter(phase, i) >= 0)
        p[i] = (*w)[layout_.parameter(phase, i)] * problem_.phases()[phase].nominal_parameter(i);
  return p;
}

}  // namespace saltus
