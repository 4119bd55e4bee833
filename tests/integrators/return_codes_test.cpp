// Tests the classification of SUNDIALS return codes: every code that the library calls a failure is
// a failure here.
#include <gtest/gtest.h>

#include "saltus/integrators/cvodes_memory.hpp"
#include "saltus/integrators/idas_memory.hpp"

namespace saltus::sundials {
namespace {

constexpr int least_code = -200;  // below all of CVODES and IDAS

TEST(ReturnCodes, FailuresAreNotSuccesses) {
  for (int code = least_code; code < 0; ++code) {
    EXPECT_NE(status_of_cvode(code), IntegrationStatus::success) << code;
    EXPECT_NE(status_of_ida(code), IntegrationStatus::success) << code;
  }
}

TEST(ReturnCodes, WarningsAndEndsAreSuccesses) {
  for (const int code : {CV_SUCCESS, CV_TSTOP_RETURN, CV_ROOT_RETURN, CV_WARNING})
    EXPECT_EQ(status_of_cvode(code), IntegrationStatus::success) << code;
  for (const int code : {IDA_SUCCESS, IDA_TSTOP_RETURN, IDA_ROOT_RETURN, IDA_WARNING})
    EXPECT_EQ(status_of_ida(code), IntegrationStatus::success) << code;
}

TEST(ReturnCodes, NameTheFailure) {
  EXPECT_EQ(status_of_cvode(CV_TOO_MUCH_WORK), IntegrationStatus::too_many_steps);
  EXPECT_EQ(status_of_ida(IDA_TOO_MUCH_WORK), IntegrationStatus::too_many_steps);
  for (const int code :
       {CV_TOO_MUCH_ACC, CV_ERR_FAILURE, CV_CONV_FAILURE, CV_LSETUP_FAIL, CV_LSOLVE_FAIL})
    EXPECT_EQ(status_of_cvode(code), IntegrationStatus::step_too_small) << code;
  for (const int code :
       {IDA_TOO_MUCH_ACC, IDA_ERR_FAIL, IDA_CONV_FAIL, IDA_LSETUP_FAIL, IDA_LSOLVE_FAIL})
    EXPECT_EQ(status_of_ida(code), IntegrationStatus::step_too_small) << code;
  for (const int code :
       {CV_RHSFUNC_FAIL, CV_REPTD_RHSFUNC_ERR, CV_SRHSFUNC_FAIL, CV_REPTD_SRHSFUNC_ERR})
    EXPECT_EQ(status_of_cvode(code), IntegrationStatus::not_finite) << code;
  for (const int code : {IDA_RES_FAIL, IDA_REP_RES_ERR, IDA_SRES_FAIL, IDA_REP_SRES_ERR})
    EXPECT_EQ(status_of_ida(code), IntegrationStatus::not_finite) << code;
  EXPECT_EQ(status_of_cvode(CV_MEM_NULL), IntegrationStatus::library_failure);
  EXPECT_EQ(status_of_ida(IDA_MEM_NULL), IntegrationStatus::library_failure);
}

}  // namespace
}  // namespace saltus::sundials
