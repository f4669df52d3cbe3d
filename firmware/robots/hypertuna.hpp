/// hypertuna: written by `hypertuna firmware params` from its description. Do not edit.
#pragma once

#include "app/vehicle/parameters.hpp"

// clang-format off
namespace hypertuna::firmware::robot {

inline constexpr float values[] = {
    0.01f,  // controller tick[0]
    0.8187308f,  // controller relax[0]
    0.9048374f,  // controller couple[0]
    0.15813f,  // controller smoothing_rate[0]
    0.8537388f,  // controller smoothing_decay[0]
    0.97626495f,  // controller servo_loop[0]
    0.3767155f,  // controller servo_decay[0]
    0.0051040207f,  // controller viscosity_min[0]
    0.10045777f,  // controller viscosity_own[0]
    0.7f,  // controller learning[0]
    0.25f,  // controller missing[0]
    0.1f,  // controller limited[0]
    0.05f,  // controller moving[0]
    0.05235988f,  // controller amplitude_min[0]
    0.0f,  // controller direct[0]
    0.3811799f,  // controller reach[0]
    0.31764993f,  // controller amplitude[0]
    26.681934f,  // controller rate[0]
    21.440842f,  // controller sent_rate[0]
    1.5708f,  // controller bend_range[0]
    0.31933653f,  // controller bend_step[0]
    0.949451f,  // controller safe_static[0]
    0.034850474f,  // controller safe_rate[0]
    1.4523479f,  // controller safe_square[0]
    0.0f,  // controller direct[1]
    0.65345126f,  // controller reach[1]
    0.54454273f,  // controller amplitude[1]
    49.42545f,  // controller rate[1]
    39.71688f,  // controller sent_rate[1]
    1.5708f,  // controller bend_range[1]
    0.54743403f,  // controller bend_step[1]
    0.56504613f,  // controller safe_static[1]
    0.025744127f,  // controller safe_rate[1]
    1.1527143f,  // controller safe_square[1]
    -0.3354383f,  // controller map_low[0]
    0.3354383f,  // controller map_high[0]
    0.6260668f,  // controller map[0]
    -0.76682174f,  // controller map[1]
    1.1155764f,  // controller map[2]
    23.543314f,  // controller map[3]
    1.687398f,  // controller map[4]
    -8.915691f,  // controller map[5]
    7.5f,  // controller servo_speed[0]
    993660.44f,  // controller servo_stall[0]
    130000.0f,  // controller fill[0]
    2.4137333e-07f,  // controller compliance[0]
    63606.56f,  // controller line[0]
    25142.664f,  // controller hammer[0]
    1e+09f,  // controller draw[0]
    1e+09f,  // controller smooth[0]
    0.0f,  // controller spare[0]
    385575.72f,  // controller hold[0]
    -101236.57f,  // controller hold[1]
    18398.89f,  // controller hold[2]
    1.4960989e+06f,  // controller hold[3]
    -0.3354383f,  // controller map_low[1]
    0.3354383f,  // controller map_high[1]
    0.6260668f,  // controller map[6]
    -0.76682174f,  // controller map[7]
    1.1155764f,  // controller map[8]
    23.543314f,  // controller map[9]
    1.687398f,  // controller map[10]
    -8.915691f,  // controller map[11]
    7.5f,  // controller servo_speed[1]
    993660.44f,  // controller servo_stall[1]
    130000.0f,  // controller fill[1]
    2.4137333e-07f,  // controller compliance[1]
    63606.56f,  // controller line[1]
    25142.664f,  // controller hammer[1]
    1e+09f,  // controller draw[1]
    1e+09f,  // controller smooth[1]
    0.0f,  // controller spare[1]
    385575.72f,  // controller hold[4]
    -101236.57f,  // controller hold[5]
    18398.89f,  // controller hold[6]
    1.4960989e+06f,  // controller hold[7]
    -0.64038223f,  // controller map_low[2]
    0.64038223f,  // controller map_high[2]
    0.21375552f,  // controller map[12]
    -0.18032871f,  // controller map[13]
    3.4688876f,  // controller map[14]
    177.36696f,  // controller map[15]
    2.7592924f,  // controller map[16]
    -122.73375f,  // controller map[17]
    7.5f,  // controller servo_speed[2]
    993660.44f,  // controller servo_stall[2]
    130000.0f,  // controller fill[2]
    1.2606594e-07f,  // controller compliance[2]
    159016.39f,  // controller line[2]
    39754.043f,  // controller hammer[2]
    1e+09f,  // controller draw[2]
    1e+09f,  // controller smooth[2]
    0.0f,  // controller spare[2]
    228156.2f,  // controller hold[8]
    -1228.3866f,  // controller hold[9]
    -12434.553f,  // controller hold[10]
    5928.2617f,  // controller hold[11]
    -0.64038223f,  // controller map_low[3]
    0.64038223f,  // controller map_high[3]
    0.21375552f,  // controller map[18]
    -0.18032871f,  // controller map[19]
    3.4688876f,  // controller map[20]
    177.36696f,  // controller map[21]
    2.7592924f,  // controller map[22]
    -122.73375f,  // controller map[23]
    7.5f,  // controller servo_speed[3]
    993660.44f,  // controller servo_stall[3]
    130000.0f,  // controller fill[3]
    1.2606594e-07f,  // controller compliance[3]
    159016.39f,  // controller line[3]
    39754.043f,  // controller hammer[3]
    1e+09f,  // controller draw[3]
    1e+09f,  // controller smooth[3]
    0.0f,  // controller spare[3]
    228156.2f,  // controller hold[12]
    -1228.3866f,  // controller hold[13]
    -12434.553f,  // controller hold[14]
    5928.2617f,  // controller hold[15]
    440000.0f,  // controller pressure_work[0]
    550000.0f,  // controller pressure_soft[0]
    660000.0f,  // controller pressure_hard[0]
    -100000.0f,  // controller pressure_low[0]
    1e+06f,  // controller pressure_high[0]
    440000.0f,  // controller pressure_step[0]
    -5.0f,  // controller current_low[0]
    5.0f,  // controller current_high[0]
    34.9f,  // controller rate_high[0]
    157.0f,  // controller acceleration_high[0]
    7.4f,  // controller voltage_rated[0]
    12.8f,  // controller voltage_low[0]
    0.0f,  // controller voltage_min[0]
    20.0f,  // controller voltage_max[0]
    8.0f,  // controller frequency_max[0]
    0.7853982f,  // controller fin_max[0]
    50.0f,  // controller timeout[0]
    0.0015f,  // controller pulse_center[0]
    0.000637f,  // controller pulse_per_rad[0]
    0.0008f,  // controller pulse_min[0]
    0.0022f,  // controller pulse_max[0]
    15.0f,  // controller slew[0]
    10.0f,  // pilot every[0]
    0.01f,  // pilot tick[0]
    0.2f,  // pilot gravity_rate[0]
    0.2f,  // pilot field_rate[0]
    0.017453292f,  // pilot drift_max[0]
    34.9f,  // pilot rate_max[0]
    157.0f,  // pilot acceleration_max[0]
    0.5f,  // pilot field_low[0]
    1.5f,  // pilot field_high[0]
    1.5f,  // pilot depth_rate[0]
    -10.3f,  // pilot depth_low[0]
    30.0f,  // pilot depth_high[0]
    0.5f,  // pilot depth_step[0]
    0.0f,  // pilot depth_repeat[0]
    0.0f,  // pilot field_repeat[0]
    0.8014128f,  // pilot glide[0]
    0.05f,  // pilot position_walk[0]
    0.002f,  // pilot current_walk[0]
    0.001f,  // pilot factor_walk[0]
    3.0f,  // pilot start_error[0]
    0.1f,  // pilot current_error[0]
    0.1f,  // pilot factor_error[0]
    1.5f,  // pilot fix_noise[0]
    1.5f,  // pilot fix_offset[0]
    12.0f,  // pilot fix_error_max[0]
    0.24f,  // pilot fix_depth[0]
    -5.2319064f,  // pilot air_low[0]
    0.73139656f,  // pilot air_high[0]
    0.1663f,  // pilot antenna_x[0]
    0.086f,  // pilot antenna_z[0]
    0.1f,  // pilot period[0]
    0.303f,  // pilot speed[0]
    2.0f,  // pilot frequency[0]
    0.27925268f,  // pilot swing[0]
    0.0f,  // pilot lag[0]
    0.43633232f,  // pilot swing[1]
    0.0f,  // pilot lag[1]
    0.45f,  // pilot speed[1]
    3.0f,  // pilot frequency[1]
    0.27925268f,  // pilot swing[2]
    0.0f,  // pilot lag[2]
    0.43633232f,  // pilot swing[3]
    0.0f,  // pilot lag[3]
    0.475f,  // pilot speed[2]
    5.21f,  // pilot frequency[2]
    0.2713987f,  // pilot swing[4]
    0.0f,  // pilot lag[4]
    0.3635521f,  // pilot swing[5]
    0.8974483f,  // pilot lag[5]
    0.13962634f,  // pilot bias_max[0]
    0.3811799f,  // pilot bend_max[0]
    0.20943952f,  // pilot bias_max[1]
    0.65345126f,  // pilot bend_max[1]
    1.1183531f,  // pilot curvature[0]
    0.4f,  // pilot heading_rate[0]
    0.29670596f,  // pilot turn_max[0]
    0.5f,  // pilot rate_gain[0]
    0.1f,  // pilot heading_integral[0]
    0.1f,  // pilot speed_min[0]
    4.0f,  // pilot lookahead[0]
    1.5f,  // pilot depth_lookahead[0]
    0.5f,  // pilot pitch_max[0]
    0.20791169f,  // pilot climb_max[0]
    2.0f,  // pilot climb_lead[0]
    0.6f,  // pilot climb_gain[0]
    0.05f,  // pilot depth_integral[0]
    0.0f,  // pilot pitch_gain[0]
    0.4f,  // pilot pitch_damping[0]
    0.7853982f,  // pilot fin_angle_max[0]
    0.12f,  // pilot surface_depth[0]
    3.0f,  // pilot fence_margin[0]
    12.0f,  // pilot error_max[0]
    4.0f,  // pilot error_near[0]
    40.0f,  // pilot error_lost[0]
    1.8973666f,  // pilot error_fix[0]
    0.24f,  // pilot depth_tolerance[0]
    180.0f,  // pilot arrival_timeout[0]
    0.02f,  // pilot drift_error_max[0]
    60.0f,  // pilot fix_timeout[0]
    180.0f,  // pilot retry[0]
    2.0f,  // pilot sensor_timeout[0]
    120.0f,  // pilot compass_timeout[0]
    0.026176948f,  // pilot fin_tilt[0]
    0.20943952f,  // pilot fin_min[0]
    10.0f,  // pilot fin_after[0]
    0.5235988f,  // pilot single_fin_max[0]
    25.0f,  // pilot response_time[0]
    0.3f,  // pilot response_depth[0]
    0.34906584f,  // pilot blind_fin[0]
    0.25f,  // pilot blind_speed[0]
    12.24f,  // pilot battery_empty[0]
    4.56f,  // pilot battery_span[0]
    0.30625f,  // pilot battery_drop[0]
    5398.565f,  // pilot endurance[0]
    30.0f,  // pilot overhead[0]
    32768.0f,  // calibration bend_zero[0]
    32768.0f,  // calibration bend_zero[1]
    5.9921265e-05f,  // calibration bend_scale[0]
    5.9921265e-05f,  // calibration bend_scale[1]
    11319.8545f,  // calibration pressure_zero[0]
    11319.8545f,  // calibration pressure_zero[1]
    11319.8545f,  // calibration pressure_zero[2]
    11319.8545f,  // calibration pressure_zero[3]
    20.980835f,  // calibration pressure_scale[0]
    20.980835f,  // calibration pressure_scale[1]
    20.980835f,  // calibration pressure_scale[2]
    20.980835f,  // calibration pressure_scale[3]
    32768.0f,  // calibration current_zero[0]
    32768.0f,  // calibration current_zero[1]
    32768.0f,  // calibration current_zero[2]
    32768.0f,  // calibration current_zero[3]
    0.00019073486f,  // calibration current_scale[0]
    0.00019073486f,  // calibration current_scale[1]
    0.00019073486f,  // calibration current_scale[2]
    0.00019073486f,  // calibration current_scale[3]
    0.0f,  // calibration rate_zero[0]
    0.0f,  // calibration rate_zero[1]
    0.0f,  // calibration rate_zero[2]
    0.0010650635f,  // calibration rate_scale[0]
    0.0010650635f,  // calibration rate_scale[1]
    0.0010650635f,  // calibration rate_scale[2]
    0.0f,  // calibration acceleration_zero[0]
    0.0f,  // calibration acceleration_zero[1]
    0.0f,  // calibration acceleration_zero[2]
    0.0047912598f,  // calibration acceleration_scale[0]
    0.0047912598f,  // calibration acceleration_scale[1]
    0.0047912598f,  // calibration acceleration_scale[2]
    6553.6f,  // calibration voltage_zero[0]
    0.00038146973f,  // calibration voltage_scale[0]
    10132.5f,  // calibration depth_zero[0]
    0.001019368f,  // calibration depth_scale[0]
    0.0f,  // calibration field_zero[0]
    0.0f,  // calibration field_zero[1]
    0.0f,  // calibration field_zero[2]
    6.1035156e-05f,  // calibration field_scale[0]
    6.1035156e-05f,  // calibration field_scale[1]
    6.1035156e-05f,  // calibration field_scale[2]
    0.0f,  // calibration servo_trim[0]
    0.0f,  // calibration servo_trim[1]
    0.0f,  // calibration servo_trim[2]
    0.0f,  // calibration servo_trim[3]
    0.0f,  // calibration servo_trim[4]
    0.0f,  // calibration servo_trim[5]
    1.0f,  // limits manual_timeout[0]
    5.0f,  // limits link_timeout[0]
    60.0f,  // limits home_timeout[0]
    12.0f,  // limits voltage_empty[0]
    5.0f,  // limits voltage_after[0]
    0.8660254f,  // limits tilt_max[0]
    3.0f,  // limits tilt_after[0]
    1.0f,  // limits leak_after[0]
    1.5f,  // limits rise_depth[0]
    10.0f,  // limits depth_max[0]
    4800.0f,  // limits link_rate[0]
    0.75f,  // limits link_share[0]
    1.0f,  // limits system_id[0]
    0.0f,  // limits sign[0]
    3.0f,  // limits leak_answer[0]
    3.0f,  // limits snag_answer[0]
    0.0f,  // limits stroke_answer[0]
    1.0f,  // limits guard_answer[0]
    30.0f,  // limits snag_distance[0]
    0.4f,  // limits sink_depth[0]
    30.0f,  // limits beacon_interval[0]
};

inline constexpr ParameterInfo parameters[] = {
    {"learning", 0.0f, 1.0f, 0.7f, false, 9},
    {"amplitude_0", 0.0f, 0.31764993f, 0.31764993f, false, 16},
    {"amplitude_1", 0.0f, 0.54454273f, 0.54454273f, false, 26},
    {"pressure_work", 220000.0f, 440000.0f, 440000.0f, false, 118},
    {"pressure_soft", 275000.0f, 550000.0f, 550000.0f, false, 119},
    {"pressure_hard", 330000.0f, 660000.0f, 660000.0f, false, 120},
    {"frequency_max", 0.8f, 8.0f, 8.0f, false, 132},
    {"fin_max", 0.0f, 0.7853982f, 0.7853982f, false, 133},
    {"voltage_low", 12.8f, 15.360001f, 12.8f, false, 129},
    {"timeout_ticks", 10.0f, 50.0f, 50.0f, true, 134},
    {"pulse_center", 0.00135f, 0.00165f, 0.0015f, false, 135},
    {"pulse_per_rad", 0.00050960004f, 0.00079625f, 0.000637f, false, 136},
    {"pulse_min", 0.0008f, 0.0011999999f, 0.0008f, false, 137},
    {"pulse_max", 0.00165f, 0.0022f, 0.0022f, false, 138},
    {"slew", 1.5f, 15.0f, 15.0f, false, 139},
    {"heading_rate", 0.2f, 0.8f, 0.4f, false, 194},
    {"heading_integral", 0.05f, 0.2f, 0.1f, false, 197},
    {"rate_gain", 0.25f, 1.0f, 0.5f, false, 196},
    {"turn_max", 0.14835298f, 0.5934119f, 0.29670596f, false, 195},
    {"curvature", 0.55917656f, 2.2367063f, 1.1183531f, false, 193},
    {"lookahead", 2.0f, 8.0f, 4.0f, false, 199},
    {"depth_lookahead", 0.75f, 3.0f, 1.5f, false, 200},
    {"depth_integral", 0.025f, 0.1f, 0.05f, false, 205},
    {"climb_lead", 1.0f, 4.0f, 2.0f, false, 203},
    {"climb_gain", 0.3f, 1.2f, 0.6f, false, 204},
    {"pitch_damping", 0.2f, 0.8f, 0.4f, false, 207},
    {"speed_min", 0.05f, 0.2f, 0.1f, false, 198},
    {"surface_depth", 0.06f, 0.24f, 0.12f, false, 209},
    {"fence_margin", 1.5f, 6.0f, 3.0f, false, 210},
    {"error_max", 6.0f, 24.0f, 12.0f, false, 211},
    {"fix_timeout", 30.0f, 120.0f, 60.0f, false, 218},
    {"bend_zero_0", -65536.0f, 65536.0f, 32768.0f, false, 235},
    {"bend_zero_1", -65536.0f, 65536.0f, 32768.0f, false, 236},
    {"bend_scale_0", 1.4980316e-05f, 0.00023968506f, 5.9921265e-05f, false, 237},
    {"bend_scale_1", 1.4980316e-05f, 0.00023968506f, 5.9921265e-05f, false, 238},
    {"pressure_zero_0", -65536.0f, 65536.0f, 11319.8545f, false, 239},
    {"pressure_zero_1", -65536.0f, 65536.0f, 11319.8545f, false, 240},
    {"pressure_zero_2", -65536.0f, 65536.0f, 11319.8545f, false, 241},
    {"pressure_zero_3", -65536.0f, 65536.0f, 11319.8545f, false, 242},
    {"pressure_scale_0", 5.2452087f, 83.92334f, 20.980835f, false, 243},
    {"pressure_scale_1", 5.2452087f, 83.92334f, 20.980835f, false, 244},
    {"pressure_scale_2", 5.2452087f, 83.92334f, 20.980835f, false, 245},
    {"pressure_scale_3", 5.2452087f, 83.92334f, 20.980835f, false, 246},
    {"current_zero_0", -65536.0f, 65536.0f, 32768.0f, false, 247},
    {"current_zero_1", -65536.0f, 65536.0f, 32768.0f, false, 248},
    {"current_zero_2", -65536.0f, 65536.0f, 32768.0f, false, 249},
    {"current_zero_3", -65536.0f, 65536.0f, 32768.0f, false, 250},
    {"current_scale_0", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 251},
    {"current_scale_1", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 252},
    {"current_scale_2", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 253},
    {"current_scale_3", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 254},
    {"voltage_zero", -65536.0f, 65536.0f, 6553.6f, false, 267},
    {"voltage_scale", 9.536743e-05f, 0.0015258789f, 0.00038146973f, false, 268},
    {"rate_zero_0", -327.68f, 327.68f, 0.0f, false, 255},
    {"rate_zero_1", -327.68f, 327.68f, 0.0f, false, 256},
    {"rate_zero_2", -327.68f, 327.68f, 0.0f, false, 257},
    {"rate_scale_0", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 258},
    {"rate_scale_1", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 259},
    {"rate_scale_2", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 260},
    {"accel_zero_0", -327.68f, 327.68f, 0.0f, false, 261},
    {"accel_zero_1", -327.68f, 327.68f, 0.0f, false, 262},
    {"accel_zero_2", -327.68f, 327.68f, 0.0f, false, 263},
    {"accel_scale_0", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 264},
    {"accel_scale_1", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 265},
    {"accel_scale_2", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 266},
    {"depth_zero", 8106.0f, 12159.0f, 10132.5f, false, 269},
    {"depth_scale", 0.00091743114f, 0.0011213047f, 0.001019368f, false, 270},
    {"field_zero_0", -32768.0f, 32768.0f, 0.0f, false, 271},
    {"field_zero_1", -32768.0f, 32768.0f, 0.0f, false, 272},
    {"field_zero_2", -32768.0f, 32768.0f, 0.0f, false, 273},
    {"field_scale_0", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 274},
    {"field_scale_1", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 275},
    {"field_scale_2", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 276},
    {"servo_trim_0", -0.0002f, 0.0002f, 0.0f, false, 277},
    {"servo_trim_1", -0.0002f, 0.0002f, 0.0f, false, 278},
    {"servo_trim_2", -0.0002f, 0.0002f, 0.0f, false, 279},
    {"servo_trim_3", -0.0002f, 0.0002f, 0.0f, false, 280},
    {"servo_trim_4", -0.0002f, 0.0002f, 0.0f, false, 281},
    {"servo_trim_5", -0.0002f, 0.0002f, 0.0f, false, 282},
    {"manual_timeout", 0.1f, 1.0f, 1.0f, false, 283},
    {"link_timeout", 1.0f, 10.0f, 5.0f, false, 284},
    {"home_timeout", 12.0f, 600.0f, 60.0f, false, 285},
    {"voltage_empty", 12.0f, 14.4f, 12.0f, false, 286},
    {"tilt_max", 0.4330127f, 0.8660254f, 0.8660254f, false, 288},
    {"rise_depth", 0.3f, 6.0f, 1.5f, false, 291},
    {"depth_max", 0.5f, 10.0f, 10.0f, false, 292},
    {"link_rate", 300.0f, 115200.0f, 4800.0f, false, 293},
    {"link_share", 0.05f, 1.0f, 0.75f, false, 294},
    {"system_id", 1.0f, 250.0f, 1.0f, true, 295},
    {"sign", 0.0f, 1.0f, 0.0f, true, 296},
    {"snag_distance", 0.0f, 500.0f, 30.0f, false, 301},
    {"sink_depth", 0.1f, 10.0f, 0.4f, false, 302},
    {"beacon_interval", 1.0f, 600.0f, 30.0f, false, 303},
    {"leak_answer", 0.0f, 3.0f, 3.0f, true, 297},
    {"snag_answer", 0.0f, 3.0f, 3.0f, true, 298},
    {"stroke_answer", 0.0f, 3.0f, 0.0f, true, 299},
    {"guard_answer", 0.0f, 3.0f, 1.0f, true, 300},
};

inline constexpr std::uint8_t file_0[] = {
    123, 34, 118, 101, 114, 115, 105, 111, 110, 34, 58, 49, 44, 34, 109, 101, 116, 97, 100, 97, 116, 97, 84, 121,
    112, 101, 115, 34, 58, 91, 123, 34, 116, 121, 112, 101, 34, 58, 49, 44, 34, 117, 114, 105, 34, 58, 34, 109,
    102, 116, 112, 58, 47, 47, 112, 97, 114, 97, 109, 101, 116, 101, 114, 115, 46, 106, 115, 111, 110, 46, 120, 122,
    34, 44, 34, 102, 105, 108, 101, 67, 114, 99, 34, 58, 57, 52, 48, 54, 54, 57, 52, 52, 51, 125, 93, 125,
};
inline constexpr std::uint8_t file_1[] = {
    253, 55, 122, 88, 90, 0, 0, 1, 105, 34, 222, 54, 2, 0, 33, 1, 28, 0, 0, 0, 16, 207, 88, 204,
    224, 67, 30, 9, 186, 93, 0, 61, 136, 138, 198, 148, 83, 144, 134, 166, 99, 125, 37, 52, 16, 60, 26, 62,
    243, 151, 185, 7, 52, 114, 247, 250, 90, 5, 43, 183, 160, 78, 94, 58, 111, 84, 221, 30, 57, 49, 177, 11,
    245, 190, 43, 198, 213, 24, 159, 252, 202, 16, 164, 92, 55, 139, 166, 177, 171, 182, 103, 160, 21, 192, 135, 185,
    132, 57, 141, 107, 167, 85, 156, 144, 230, 108, 14, 237, 234, 132, 213, 221, 64, 145, 235, 42, 187, 22, 160, 2,
    85, 117, 97, 96, 155, 185, 140, 24, 201, 117, 196, 74, 127, 68, 82, 143, 7, 48, 111, 5, 201, 87, 137, 246,
    214, 244, 176, 160, 36, 255, 50, 178, 199, 80, 87, 180, 239, 215, 123, 182, 14, 211, 208, 194, 1, 190, 110, 170,
    224, 185, 77, 119, 184, 51, 92, 175, 102, 173, 111, 183, 134, 18, 226, 162, 165, 11, 204, 152, 198, 23, 99, 114,
    163, 189, 194, 184, 245, 206, 234, 167, 132, 92, 38, 207, 174, 130, 145, 247, 65, 34, 84, 38, 134, 77, 20, 215,
    197, 27, 11, 196, 83, 166, 231, 147, 251, 125, 147, 80, 163, 140, 214, 199, 123, 64, 183, 63, 202, 188, 78, 105,
    136, 241, 57, 7, 146, 100, 160, 21, 134, 230, 47, 68, 120, 87, 188, 110, 130, 113, 62, 154, 180, 95, 204, 124,
    248, 167, 100, 77, 121, 205, 145, 181, 206, 144, 172, 217, 117, 107, 141, 110, 180, 1, 136, 203, 166, 110, 198, 246,
    181, 201, 128, 255, 3, 153, 80, 29, 8, 205, 97, 30, 24, 34, 88, 64, 25, 134, 16, 38, 152, 128, 190, 243,
    235, 168, 54, 26, 114, 250, 237, 254, 220, 219, 188, 172, 166, 252, 146, 121, 244, 88, 234, 90, 188, 241, 213, 130,
    224, 30, 217, 35, 197, 165, 15, 156, 87, 21, 181, 4, 39, 35, 19, 79, 157, 255, 121, 37, 135, 215, 45, 20,
    75, 150, 149, 225, 164, 220, 75, 112, 66, 196, 35, 55, 40, 44, 4, 89, 92, 229, 206, 75, 176, 144, 74, 229,
    205, 132, 251, 128, 197, 37, 45, 91, 45, 179, 207, 106, 148, 100, 140, 14, 0, 205, 61, 198, 223, 71, 167, 255,
    251, 112, 228, 182, 102, 99, 58, 167, 139, 140, 87, 128, 127, 179, 255, 19, 36, 245, 70, 220, 171, 66, 148, 4,
    254, 42, 105, 97, 240, 148, 211, 250, 21, 13, 70, 203, 107, 108, 60, 62, 241, 217, 193, 123, 190, 24, 244, 59,
    11, 98, 198, 179, 249, 90, 157, 56, 14, 122, 107, 69, 174, 86, 74, 98, 31, 81, 177, 65, 203, 129, 190, 163,
    231, 192, 226, 66, 192, 140, 85, 255, 20, 134, 148, 196, 204, 20, 200, 137, 99, 161, 131, 164, 183, 29, 10, 91,
    155, 168, 126, 78, 254, 243, 201, 214, 180, 206, 157, 78, 109, 112, 58, 214, 191, 41, 190, 209, 167, 69, 2, 213,
    13, 177, 254, 52, 245, 215, 176, 98, 6, 36, 229, 247, 29, 143, 79, 34, 157, 241, 231, 187, 41, 161, 133, 100,
    18, 74, 108, 233, 241, 151, 253, 19, 38, 236, 146, 49, 151, 158, 183, 14, 31, 151, 169, 162, 40, 218, 85, 2,
    37, 176, 153, 234, 135, 2, 248, 128, 218, 185, 218, 102, 44, 12, 144, 249, 140, 181, 29, 163, 91, 204, 250, 238,
    170, 188, 232, 172, 198, 170, 45, 125, 57, 156, 194, 117, 115, 46, 35, 94, 79, 141, 69, 193, 103, 116, 226, 35,
    218, 136, 75, 17, 96, 202, 171, 109, 125, 226, 124, 55, 81, 222, 83, 182, 207, 206, 186, 126, 235, 137, 10, 4,
    28, 148, 97, 178, 83, 81, 188, 33, 18, 159, 250, 75, 29, 138, 77, 206, 99, 3, 86, 129, 245, 143, 202, 156,
    107, 212, 118, 160, 73, 0, 27, 129, 70, 114, 147, 134, 66, 27, 172, 9, 182, 136, 98, 70, 215, 29, 72, 236,
    17, 167, 243, 204, 47, 226, 145, 125, 224, 243, 107, 76, 125, 226, 27, 84, 244, 177, 163, 18, 147, 20, 249, 100,
    99, 36, 153, 222, 81, 95, 215, 7, 209, 200, 113, 104, 17, 72, 171, 32, 19, 81, 232, 108, 152, 113, 1, 125,
    164, 192, 198, 23, 52, 59, 165, 66, 88, 0, 134, 193, 237, 78, 46, 24, 215, 60, 140, 252, 95, 90, 222, 131,
    191, 189, 224, 97, 25, 61, 131, 56, 157, 156, 2, 125, 37, 62, 8, 6, 1, 144, 31, 251, 20, 208, 253, 174,
    25, 117, 204, 51, 142, 58, 246, 44, 164, 184, 145, 252, 120, 66, 163, 230, 167, 171, 54, 77, 135, 43, 185, 162,
    153, 240, 8, 246, 14, 119, 70, 109, 218, 160, 49, 117, 246, 200, 233, 50, 240, 254, 122, 139, 189, 24, 140, 99,
    148, 227, 240, 104, 254, 35, 189, 159, 46, 91, 213, 230, 228, 13, 95, 182, 34, 57, 18, 140, 55, 200, 150, 47,
    31, 139, 140, 6, 252, 251, 93, 111, 184, 240, 102, 80, 95, 195, 26, 8, 48, 179, 146, 222, 116, 242, 3, 239,
    47, 63, 78, 6, 188, 203, 185, 244, 57, 97, 234, 104, 127, 73, 90, 174, 25, 182, 246, 40, 154, 78, 92, 148,
    49, 144, 133, 129, 200, 4, 235, 42, 50, 119, 255, 204, 17, 228, 48, 180, 44, 245, 123, 213, 185, 146, 8, 249,
    15, 137, 177, 244, 138, 19, 221, 79, 180, 83, 145, 90, 101, 123, 113, 220, 150, 107, 151, 2, 233, 5, 24, 110,
    187, 15, 23, 208, 144, 215, 101, 146, 8, 16, 132, 205, 129, 72, 198, 50, 59, 178, 8, 99, 176, 123, 195, 231,
    169, 85, 87, 75, 31, 120, 235, 47, 189, 40, 55, 215, 12, 40, 179, 197, 211, 90, 195, 128, 199, 235, 9, 44,
    26, 138, 165, 168, 180, 238, 187, 14, 2, 21, 213, 140, 50, 118, 68, 230, 172, 19, 116, 154, 214, 95, 254, 162,
    86, 100, 191, 162, 23, 238, 76, 27, 152, 158, 170, 249, 181, 156, 86, 122, 34, 35, 185, 130, 83, 250, 94, 231,
    207, 128, 42, 70, 53, 7, 15, 98, 11, 202, 130, 87, 145, 228, 194, 175, 185, 16, 116, 106, 183, 85, 183, 171,
    171, 44, 162, 237, 82, 30, 71, 50, 112, 174, 145, 98, 18, 168, 145, 132, 132, 77, 200, 115, 152, 75, 88, 202,
    232, 14, 68, 99, 10, 69, 202, 5, 190, 27, 203, 82, 10, 11, 185, 13, 187, 214, 18, 100, 222, 84, 80, 186,
    7, 255, 196, 57, 61, 3, 94, 244, 173, 190, 207, 255, 100, 249, 94, 237, 136, 4, 244, 66, 71, 253, 214, 80,
    63, 212, 208, 146, 252, 113, 5, 112, 134, 176, 145, 182, 88, 208, 43, 48, 80, 134, 82, 75, 85, 110, 109, 207,
    194, 123, 222, 12, 90, 79, 216, 104, 118, 212, 10, 240, 184, 113, 38, 234, 198, 241, 23, 98, 146, 201, 145, 170,
    128, 219, 40, 207, 28, 126, 147, 166, 158, 37, 202, 173, 132, 55, 45, 136, 50, 212, 8, 238, 249, 23, 243, 251,
    51, 0, 173, 144, 219, 93, 158, 28, 120, 13, 122, 92, 76, 177, 73, 99, 228, 159, 140, 119, 56, 49, 94, 96,
    254, 74, 202, 245, 181, 100, 108, 21, 236, 106, 225, 196, 198, 68, 171, 107, 61, 199, 237, 48, 213, 31, 69, 246,
    176, 232, 126, 61, 93, 35, 7, 247, 64, 45, 229, 0, 74, 139, 180, 191, 254, 209, 119, 128, 98, 67, 13, 7,
    103, 7, 151, 55, 96, 109, 239, 184, 119, 85, 58, 11, 76, 180, 125, 252, 208, 76, 164, 63, 156, 91, 204, 45,
    42, 57, 63, 34, 78, 235, 147, 54, 68, 165, 167, 235, 167, 118, 67, 173, 211, 9, 2, 63, 57, 32, 145, 26,
    215, 147, 178, 207, 106, 162, 67, 86, 193, 129, 204, 131, 118, 91, 219, 244, 137, 148, 44, 1, 100, 26, 192, 246,
    45, 234, 32, 61, 99, 147, 183, 118, 80, 10, 44, 89, 217, 126, 21, 36, 202, 222, 217, 225, 130, 1, 45, 231,
    234, 70, 132, 62, 237, 227, 208, 211, 245, 201, 166, 56, 178, 40, 246, 31, 178, 212, 239, 198, 55, 191, 129, 16,
    132, 52, 39, 66, 248, 217, 201, 131, 181, 95, 254, 140, 225, 135, 230, 246, 123, 135, 73, 204, 206, 215, 62, 129,
    127, 246, 44, 20, 92, 119, 255, 169, 125, 60, 165, 37, 214, 178, 157, 101, 102, 30, 64, 122, 168, 152, 83, 122,
    145, 241, 253, 160, 188, 241, 26, 111, 39, 122, 222, 28, 0, 191, 208, 129, 37, 252, 142, 172, 233, 141, 85, 188,
    122, 201, 162, 230, 42, 198, 50, 182, 116, 243, 48, 103, 226, 92, 172, 229, 224, 63, 114, 67, 125, 13, 142, 181,
    92, 115, 3, 104, 228, 76, 221, 92, 69, 244, 27, 151, 181, 234, 146, 16, 95, 122, 240, 40, 224, 39, 67, 9,
    254, 105, 216, 246, 153, 110, 155, 44, 208, 124, 207, 100, 6, 43, 227, 155, 15, 154, 139, 99, 99, 25, 62, 211,
    102, 99, 7, 208, 203, 175, 245, 165, 111, 233, 122, 169, 63, 164, 9, 104, 202, 26, 17, 139, 234, 247, 220, 215,
    236, 201, 154, 245, 34, 89, 251, 133, 64, 88, 247, 182, 157, 69, 74, 162, 127, 82, 101, 85, 82, 193, 216, 219,
    118, 233, 219, 249, 119, 69, 210, 81, 43, 27, 134, 193, 36, 66, 189, 48, 34, 124, 148, 33, 125, 193, 171, 119,
    80, 26, 196, 50, 174, 131, 203, 238, 46, 205, 64, 214, 126, 76, 84, 182, 244, 83, 203, 59, 100, 154, 213, 60,
    36, 244, 241, 118, 73, 214, 131, 161, 68, 203, 92, 50, 220, 169, 97, 254, 130, 3, 126, 38, 88, 246, 136, 189,
    7, 203, 120, 242, 161, 73, 158, 155, 96, 236, 83, 72, 247, 67, 216, 136, 46, 190, 103, 57, 86, 21, 0, 63,
    152, 41, 132, 155, 209, 129, 104, 115, 82, 243, 45, 59, 198, 254, 254, 197, 207, 181, 69, 25, 49, 162, 114, 241,
    199, 89, 113, 26, 3, 160, 180, 248, 232, 61, 51, 6, 9, 113, 23, 180, 0, 32, 242, 159, 9, 92, 241, 136,
    1, 111, 15, 146, 13, 26, 67, 120, 37, 6, 104, 181, 28, 146, 193, 1, 219, 233, 225, 27, 0, 74, 2, 122,
    27, 3, 109, 183, 107, 186, 130, 185, 245, 120, 110, 182, 101, 73, 18, 107, 203, 96, 177, 64, 69, 119, 239, 59,
    178, 78, 175, 227, 128, 99, 64, 91, 86, 182, 222, 78, 92, 73, 155, 179, 71, 248, 242, 103, 175, 41, 133, 11,
    59, 29, 127, 116, 171, 29, 60, 58, 107, 11, 194, 251, 130, 223, 4, 219, 239, 232, 207, 130, 110, 213, 121, 129,
    143, 164, 204, 53, 223, 114, 101, 171, 118, 84, 102, 249, 209, 56, 249, 143, 25, 210, 113, 124, 175, 36, 75, 188,
    127, 217, 52, 84, 124, 190, 190, 207, 216, 181, 234, 189, 31, 70, 65, 193, 43, 196, 143, 229, 141, 251, 255, 77,
    227, 22, 21, 69, 60, 41, 44, 210, 205, 29, 30, 249, 125, 241, 48, 194, 82, 85, 254, 47, 250, 67, 187, 220,
    155, 149, 217, 193, 11, 174, 123, 66, 60, 247, 1, 64, 143, 241, 202, 171, 8, 13, 97, 74, 213, 14, 229, 150,
    173, 124, 24, 38, 3, 55, 238, 235, 100, 150, 10, 77, 155, 1, 3, 26, 76, 62, 34, 243, 24, 252, 22, 27,
    112, 188, 194, 114, 224, 176, 219, 70, 106, 72, 195, 84, 23, 253, 54, 196, 24, 158, 150, 102, 66, 175, 27, 223,
    234, 237, 29, 79, 3, 206, 159, 251, 127, 57, 65, 4, 45, 168, 156, 100, 242, 18, 161, 57, 122, 63, 75, 108,
    246, 96, 134, 38, 106, 130, 209, 176, 183, 151, 255, 170, 21, 203, 44, 127, 173, 140, 203, 74, 234, 103, 140, 169,
    69, 111, 103, 44, 44, 189, 30, 230, 68, 109, 139, 158, 213, 35, 138, 242, 99, 103, 123, 107, 72, 242, 226, 163,
    18, 222, 157, 140, 142, 150, 59, 75, 62, 101, 245, 32, 95, 197, 97, 67, 93, 41, 209, 48, 146, 154, 136, 216,
    128, 222, 84, 170, 141, 116, 217, 165, 93, 222, 79, 242, 216, 161, 80, 243, 74, 205, 97, 220, 32, 165, 25, 111,
    204, 72, 243, 24, 158, 207, 35, 150, 38, 193, 47, 199, 111, 251, 42, 50, 5, 162, 12, 92, 33, 124, 134, 110,
    228, 92, 123, 212, 113, 160, 178, 30, 128, 155, 242, 165, 249, 196, 243, 186, 158, 141, 134, 116, 206, 185, 105, 145,
    214, 148, 209, 78, 60, 116, 2, 144, 226, 129, 192, 10, 207, 0, 199, 209, 168, 243, 16, 95, 8, 165, 148, 115,
    252, 72, 32, 14, 112, 181, 135, 39, 17, 171, 118, 36, 7, 212, 125, 110, 156, 246, 243, 1, 207, 63, 220, 243,
    171, 187, 202, 167, 248, 188, 68, 76, 115, 48, 99, 168, 213, 82, 67, 107, 237, 249, 200, 212, 152, 27, 35, 90,
    14, 47, 54, 64, 178, 177, 13, 22, 168, 18, 175, 220, 185, 175, 114, 21, 74, 105, 193, 237, 180, 141, 20, 31,
    250, 90, 77, 2, 55, 75, 98, 38, 127, 148, 146, 119, 10, 104, 27, 116, 39, 71, 223, 60, 2, 89, 85, 8,
    49, 228, 146, 187, 87, 198, 21, 30, 62, 193, 211, 142, 134, 9, 221, 23, 30, 35, 43, 185, 190, 64, 53, 35,
    170, 159, 32, 26, 104, 65, 116, 172, 164, 143, 91, 173, 39, 126, 189, 204, 233, 106, 126, 251, 89, 2, 190, 133,
    228, 138, 164, 33, 82, 92, 48, 216, 126, 131, 180, 24, 89, 224, 56, 181, 77, 99, 249, 207, 85, 13, 51, 135,
    161, 213, 22, 172, 0, 158, 42, 183, 223, 178, 220, 15, 202, 221, 194, 104, 34, 252, 149, 31, 30, 250, 52, 131,
    7, 195, 177, 225, 230, 73, 148, 82, 168, 20, 48, 164, 91, 3, 77, 58, 175, 236, 16, 130, 134, 146, 77, 122,
    12, 157, 43, 183, 244, 244, 72, 197, 73, 177, 240, 22, 50, 117, 60, 89, 231, 56, 10, 68, 41, 216, 183, 244,
    151, 243, 92, 251, 75, 114, 153, 174, 141, 32, 86, 66, 110, 44, 154, 172, 182, 64, 239, 140, 129, 46, 81, 174,
    55, 228, 73, 70, 14, 244, 226, 113, 20, 208, 14, 59, 218, 14, 39, 239, 50, 61, 5, 204, 68, 15, 116, 64,
    203, 163, 106, 136, 180, 49, 97, 26, 208, 215, 95, 151, 82, 43, 220, 137, 216, 82, 152, 115, 224, 103, 2, 212,
    126, 105, 134, 34, 253, 29, 243, 107, 162, 8, 8, 12, 240, 109, 151, 219, 166, 17, 194, 159, 182, 7, 198, 237,
    160, 0, 0, 0, 141, 191, 125, 224, 0, 1, 210, 19, 159, 134, 1, 0, 42, 35, 99, 162, 62, 48, 13, 139,
    2, 0, 0, 0, 0, 1, 89, 90,
};

inline constexpr FileInfo files[] = {
    {"general.json", file_0, 96, 0xb5c07174},
    {"parameters.json.xz", file_1, 2552, 0x38117a03},
};

inline constexpr Description description = {
    "hypertuna", 2, 3, values, 304, parameters, 97, 0xf8470ce9, files, 2};

inline constexpr struct {
    int servo[6];
    int analog[11];
    int leak[1];
    int recovery[1];
    int imu_serial, position_serial, radio_serial, radio_baud;
    int fix_ms;      // time between fixes
    float watchdog;  // s
} wiring = {
    {2, 3, 4, 5, 6, 9},
    {14, 15, 16, 17, 20, 21, 22, 23, 24, 25, 26},
    {28},
    {32},
    1, 8, 2, 9600,
    1000,
    0.5f,
};

}  // namespace hypertuna::firmware::robot
// clang-format on
