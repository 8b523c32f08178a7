// SPDX-License-Identifier: BSD-3-Clause
// The types that follow from the structs are those that channels.hpp, and with it every log, knows.
#include "drivers/channels.hpp"
#include "drivers/wire.hpp"
#include "drivers/wire_parameters.hpp"
#include "drivers/wire_records.hpp"
#include "drivers/wire_requests.hpp"
#include "drivers/wire_segments.hpp"
#include "drivers/wire_ssl.hpp"
#include "drivers/wire_telemetry.hpp"
#include "drivers/wire_truth.hpp"

namespace sortie::drivers {

static_assert(kFingerprintOf<rt::ImuSample> == kFingerprintImu);
static_assert(kFingerprintOf<rt::TrackSample> == kFingerprintTrack);
static_assert(kFingerprintOf<rt::PointScan> == kFingerprintScan);
static_assert(kFingerprintOf<rt::TruthSample> == kFingerprintTruth);
static_assert(kFingerprintOf<rt::ContactTruth> == kFingerprintContacts);
static_assert(kFingerprintOf<rt::SegmentList> == kFingerprintSegments);
static_assert(kFingerprintOf<rt::LocatedPose> == kFingerprintLocated);
static_assert(kFingerprintOf<rt::RecognisedPlace> == kFingerprintRecognised);
static_assert(kFingerprintOf<CanFrame> == kFingerprintCan);
static_assert(kFingerprintOf<LogHeader> == kFingerprintHeader);
static_assert(kFingerprintOf<rt::JobRecord> == kFingerprintTick);
static_assert(kFingerprintOf<JobTiming> == kFingerprintTiming);
static_assert(kFingerprintOf<JobTimingRecord> == kFingerprintTiming);
static_assert(kFingerprintOf<GapRecord> == kFingerprintGap);
static_assert(kFingerprintOf<EventRecord> == kFingerprintEvent);
static_assert(kFingerprintOf<CustomView> == kFingerprintCustom);
static_assert(kFingerprintOf<FieldsView> == kFingerprintFields &&
              kFingerprintOf<FieldsMessage> == kFingerprintFields);
static_assert(kFingerprintOf<ExecStats> == kFingerprintExecStats);
static_assert(kFingerprintOf<PoolStats> == kFingerprintPoolStats);
static_assert(kFingerprintOf<rt::ParameterChange> == kFingerprintParameter);
static_assert(kFingerprintOf<SetParameter> == kFingerprintSetParameter);
static_assert(kFingerprintOf<ParametersMessage> == kFingerprintParameters);
static_assert(kFingerprintOf<DriveRequestMessage> == kFingerprintDriveRequest);
static_assert(kFingerprintOf<FlyRequestMessage> == kFingerprintFlyRequest);
static_assert(kFingerprintOf<AnswersMessage> == kFingerprintRequestAnswers);
static_assert(kFingerprintOf<rt::SslCommand> == kFingerprintSslCommand);
static_assert(kFingerprintOf<rt::SslReturns> == kFingerprintSslReturns);
static_assert(kFingerprintOf<PoseMessage> == kFingerprintPose);

}  // namespace sortie::drivers
