// SPDX-License-Identifier: BSD-3-Clause
// The parts that robots are made of, one line each: parents before children, and in the order in which their
// tasks run. The whole of a part is its file in firmware_like/parts and its line here (docs/part-howto.md).
#pragma once

/// part(name, what, vehicle, parent, usual): made by make_NAME of firmware_like/parts/part.hpp where
/// [tasks.NAME] enabled says so. what: half a sentence; vehicle: empty for both; parent: the part that it
/// works on; usual, where the profile says nothing: "yes", "no", or the name of a part that it goes with.
///
/// option(name, what, vehicle, parent, usual, key, there, without, code): refines its parent, which reads
/// `key`. there: of a text, the values that mean "there"; without: overrides that leave it out; both between
/// spaces. code: true where a build of one scene can be without its code.
// clang-format off
#define SORTIE_PARTS(part, option) \
  part(attitude, "which way is down, from the IMU", "ugv", "", "yes") \
  option(gyro_bias, "the gyro's bias is estimated", "ugv", "attitude", "yes", \
         "attitude.bias_sigma_rad_s", "", "attitude.bias_sigma_rad_s=0", false) \
  part(odometry, "dead reckoning from tracks and attitude", "ugv", "attitude", "yes") \
  option(track_aid, "the tracks' acceleration is taken out of the specific force", "ugv", "odometry", \
         "yes", "attitude.track_aid", "on", "attitude.track_aid=off", false) \
  option(steering, "slip is judged by what the gyro has shown", "ugv", "odometry", "no", \
         "odometry.steering", "learned", "odometry.steering=fixed", false) \
  option(obstacles, "edges, falls and flippers under the robot are modelled", "ugv", "odometry", "no", \
         "odometry.obstacles", "on", "odometry.obstacles=off", true) \
  option(odometry_state, "the odometry tells its mode, slip and health", "ugv", "odometry", "obstacles", \
         "tasks.odometry_state.enabled", "", "tasks.odometry_state.enabled=false", false) \
  part(drive, "the route is driven", "ugv", "odometry", "no") \
  option(flippers, "flippers are set", "ugv", "drive", "no", "tasks.flippers.enabled", "", \
         "tasks.flippers.enabled=false", true) \
  option(canopen, "the drives speak CANopen", "ugv", "drive", "no", "drives.protocol", "canopen", \
         "drives.protocol=own", true) \
  option(odrive, "the drives are ODrives, on CANSimple", "ugv", "drive", "no", "drives.protocol", \
         "odrive", "drives.protocol=own", true) \
  part(map, "a local map of voxels", "ugv", "", "no") \
  option(self_filter, "returns from the robot itself are taken out", "ugv", "map", "no", \
         "outline.flipper_length_m", "", \
         "outline.flipper_length_m=0 outline.body_m=[0,0,0,0,0,0] outline.tracks_m=[0,0,0,0,0,0]", false) \
  option(segments, "the map is divided into segments", "ugv", "map", "yes", "map.segments", \
         "euclidean smoothness", "map.segments=off", true) \
  option(normals, "segments are smooth surfaces, by normals", "ugv", "segments", "no", "map.segments", \
         "smoothness", "map.segments=euclidean", true) \
  option(segment_lists, "lists of segments are published", "ugv", "segments", "yes", "map.publish", \
         "segments features", "map.publish=off", true) \
  part(locate, "the robot's place on a map of surfaces that it makes", "ugv", "", "no") \
  part(relocate, "a robot that is lost on a kept map looks for its place", "ugv", "locate", "no") \
  part(recognise, "segments are recognised on a known map", "ugv", "map", "no") \
  part(recognise_images, "height images of the local map are recognised on a known map", "ugv", "map", "no") \
  part(ssl, "a solid-state lidar is asked for rays", "ugv", "", "no") \
  option(ray_scheduler, "rays are planned over a map of what is known", "ugv", "ssl", "yes", \
         "ssl.policy", "scheduled", "ssl.policy=grid", true) \
  part(elevation, "heights of the ground around the robot", "ugv", "odometry", "no") \
  part(way, "ways to a goal over ground that carries", "ugv", "elevation", "no") \
  part(cloud, "cells of what it saw, for another robot to be placed on", "", "", "no") \
  part(join, "the vehicle finds its place on another robot's cloud", "", "cloud", "no") \
  option(pilot, "the vehicle is flown", "uav", "", "yes", "tasks.pilot.enabled", "", \
         "tasks.pilot.enabled=false", true) \
  option(path, "ways around what is in the way", "uav", "pilot", "no", "tasks.path.enabled", "", \
         "tasks.path.enabled=false", true) \
  option(sensed_map, "what is in the way is seen by a lidar", "uav", "path", "no", "flight_map.source", \
         "lidar", "flight_map.source=given", true) \
  option(parameters, "numbers may change while a run goes on", "", "", "yes", \
         "tasks.parameters.enabled", "", "tasks.parameters.enabled=false", false) \
  option(telemetry, "a live run tells over LCM what it does", "", "", "yes", "live.telemetry", "", \
         "live.telemetry=false", true) \
  option(recorder, "a run can be recorded", "", "", "yes", "live.recorder", "", "live.recorder=false", \
         true)
// clang-format on
