// SPDX-License-Identifier: BSD-3-Clause
// One function for each kind of data set: reads it, checks it, and hands its samples to the builder.
#pragma once

#include "toolchain/import/log_builder.hpp"
#include "toolchain/import/row_judge.hpp"

namespace sortie::toolchain {

/// Clearpath Husky: *_imu.csv, *_odom.csv and, as truth, *_gps.csv.
void import_husky(RowJudge& judge, LogBuilder& builder);

/// Plaza (dead reckoning of a mower): *_DR.txt and, as truth, *_GT.csv.
void import_plaza(RowJudge& judge, LogBuilder& builder);

/// BROAD trial: one *.imu file with inertial data and optical truth.
void import_broad(RowJudge& judge, LogBuilder& builder);

/// Recorded lidar scans with poses: one *.rls file, or all of a folder merged by time.
void import_rls(RowJudge& judge, LogBuilder& builder);

/// A drive with a planar laser and wheels as CARMEN wrote it: one *.clf or *.log file.
void import_carmen(RowJudge& judge, LogBuilder& builder);

/// Sweeps of a spinning lidar with a time for each point: one *.swp file, or all of a folder, and the
/// odometry beside them (odom.csv).
void import_swp(RowJudge& judge, LogBuilder& builder);

}  // namespace sortie::toolchain
