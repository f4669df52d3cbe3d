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
    1.5708f,  // controller bend_range[0]
    0.31933653f,  // controller bend_step[0]
    0.949451f,  // controller safe_static[0]
    0.034850474f,  // controller safe_rate[0]
    1.4523479f,  // controller safe_square[0]
    0.0f,  // controller direct[1]
    0.65345126f,  // controller reach[1]
    0.54454273f,  // controller amplitude[1]
    49.42545f,  // controller rate[1]
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
    0.15f,  // controller slew[0]
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
    0.24f,  // pilot fix_depth[0]
    12.0f,  // pilot fix_error_max[0]
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
    2.0f,  // pilot lost_after[0]
    120.0f,  // pilot compass_timeout[0]
    0.026176948f,  // pilot fin_tilt[0]
    0.20943952f,  // pilot fin_min[0]
    10.0f,  // pilot fin_after[0]
    0.5235988f,  // pilot single_fin_max[0]
    25.0f,  // pilot response_time[0]
    0.3f,  // pilot response_depth[0]
    0.34906584f,  // pilot blind_fin[0]
    0.25f,  // pilot slow[0]
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
};

inline constexpr ParameterInfo parameters[] = {
    {"learning", 0.0f, 1.0f, 0.7f, false, 9},
    {"amplitude_0", 0.0f, 0.31764993f, 0.31764993f, false, 16},
    {"amplitude_1", 0.0f, 0.54454273f, 0.54454273f, false, 25},
    {"pressure_work", 220000.0f, 440000.0f, 440000.0f, false, 88},
    {"pressure_soft", 275000.0f, 550000.0f, 550000.0f, false, 89},
    {"pressure_hard", 330000.0f, 660000.0f, 660000.0f, false, 90},
    {"frequency_max", 0.8f, 8.0f, 8.0f, false, 102},
    {"fin_max", 0.0f, 0.7853982f, 0.7853982f, false, 103},
    {"voltage_low", 12.8f, 15.360001f, 12.8f, false, 99},
    {"timeout_ticks", 10.0f, 50.0f, 50.0f, true, 104},
    {"pulse_center", 0.00135f, 0.00165f, 0.0015f, false, 105},
    {"pulse_per_rad", 0.00050960004f, 0.00079625f, 0.000637f, false, 106},
    {"pulse_min", 0.0008f, 0.0011999999f, 0.0008f, false, 107},
    {"pulse_max", 0.00165f, 0.0022f, 0.0022f, false, 108},
    {"slew", 0.015000001f, 0.15f, 0.15f, false, 109},
    {"heading_rate", 0.2f, 0.8f, 0.4f, false, 164},
    {"heading_integral", 0.05f, 0.2f, 0.1f, false, 167},
    {"rate_gain", 0.25f, 1.0f, 0.5f, false, 166},
    {"turn_max", 0.14835298f, 0.5934119f, 0.29670596f, false, 165},
    {"curvature", 0.55917656f, 2.2367063f, 1.1183531f, false, 163},
    {"lookahead", 2.0f, 8.0f, 4.0f, false, 169},
    {"depth_lookahead", 0.75f, 3.0f, 1.5f, false, 170},
    {"depth_integral", 0.025f, 0.1f, 0.05f, false, 175},
    {"climb_lead", 1.0f, 4.0f, 2.0f, false, 173},
    {"climb_gain", 0.3f, 1.2f, 0.6f, false, 174},
    {"pitch_damping", 0.2f, 0.8f, 0.4f, false, 177},
    {"speed_min", 0.05f, 0.2f, 0.1f, false, 168},
    {"surface_depth", 0.06f, 0.24f, 0.12f, false, 179},
    {"fence_margin", 1.5f, 6.0f, 3.0f, false, 180},
    {"error_max", 6.0f, 24.0f, 12.0f, false, 181},
    {"fix_timeout", 30.0f, 120.0f, 60.0f, false, 188},
    {"bend_zero_0", -65536.0f, 65536.0f, 32768.0f, false, 205},
    {"bend_zero_1", -65536.0f, 65536.0f, 32768.0f, false, 206},
    {"bend_scale_0", 1.4980316e-05f, 0.00023968506f, 5.9921265e-05f, false, 207},
    {"bend_scale_1", 1.4980316e-05f, 0.00023968506f, 5.9921265e-05f, false, 208},
    {"pressure_zero_0", -65536.0f, 65536.0f, 11319.8545f, false, 209},
    {"pressure_zero_1", -65536.0f, 65536.0f, 11319.8545f, false, 210},
    {"pressure_zero_2", -65536.0f, 65536.0f, 11319.8545f, false, 211},
    {"pressure_zero_3", -65536.0f, 65536.0f, 11319.8545f, false, 212},
    {"pressure_scale_0", 5.2452087f, 83.92334f, 20.980835f, false, 213},
    {"pressure_scale_1", 5.2452087f, 83.92334f, 20.980835f, false, 214},
    {"pressure_scale_2", 5.2452087f, 83.92334f, 20.980835f, false, 215},
    {"pressure_scale_3", 5.2452087f, 83.92334f, 20.980835f, false, 216},
    {"current_zero_0", -65536.0f, 65536.0f, 32768.0f, false, 217},
    {"current_zero_1", -65536.0f, 65536.0f, 32768.0f, false, 218},
    {"current_zero_2", -65536.0f, 65536.0f, 32768.0f, false, 219},
    {"current_zero_3", -65536.0f, 65536.0f, 32768.0f, false, 220},
    {"current_scale_0", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 221},
    {"current_scale_1", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 222},
    {"current_scale_2", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 223},
    {"current_scale_3", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 224},
    {"voltage_zero", -65536.0f, 65536.0f, 6553.6f, false, 237},
    {"voltage_scale", 9.536743e-05f, 0.0015258789f, 0.00038146973f, false, 238},
    {"rate_zero_0", -327.68f, 327.68f, 0.0f, false, 225},
    {"rate_zero_1", -327.68f, 327.68f, 0.0f, false, 226},
    {"rate_zero_2", -327.68f, 327.68f, 0.0f, false, 227},
    {"rate_scale_0", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 228},
    {"rate_scale_1", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 229},
    {"rate_scale_2", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 230},
    {"accel_zero_0", -327.68f, 327.68f, 0.0f, false, 231},
    {"accel_zero_1", -327.68f, 327.68f, 0.0f, false, 232},
    {"accel_zero_2", -327.68f, 327.68f, 0.0f, false, 233},
    {"accel_scale_0", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 234},
    {"accel_scale_1", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 235},
    {"accel_scale_2", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 236},
    {"depth_zero", 8106.0f, 12159.0f, 10132.5f, false, 239},
    {"depth_scale", 0.00091743114f, 0.0011213047f, 0.001019368f, false, 240},
    {"field_zero_0", -32768.0f, 32768.0f, 0.0f, false, 241},
    {"field_zero_1", -32768.0f, 32768.0f, 0.0f, false, 242},
    {"field_zero_2", -32768.0f, 32768.0f, 0.0f, false, 243},
    {"field_scale_0", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 244},
    {"field_scale_1", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 245},
    {"field_scale_2", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 246},
    {"servo_trim_0", -0.0002f, 0.0002f, 0.0f, false, 247},
    {"servo_trim_1", -0.0002f, 0.0002f, 0.0f, false, 248},
    {"servo_trim_2", -0.0002f, 0.0002f, 0.0f, false, 249},
    {"servo_trim_3", -0.0002f, 0.0002f, 0.0f, false, 250},
    {"servo_trim_4", -0.0002f, 0.0002f, 0.0f, false, 251},
    {"servo_trim_5", -0.0002f, 0.0002f, 0.0f, false, 252},
    {"manual_timeout", 0.1f, 1.0f, 1.0f, false, 253},
    {"link_timeout", 1.0f, 10.0f, 5.0f, false, 254},
    {"home_timeout", 12.0f, 600.0f, 60.0f, false, 255},
    {"voltage_empty", 12.0f, 14.4f, 12.0f, false, 256},
    {"tilt_max", 0.4330127f, 0.8660254f, 0.8660254f, false, 258},
    {"rise_depth", 0.3f, 6.0f, 1.5f, false, 261},
    {"depth_max", 0.5f, 10.0f, 10.0f, false, 262},
    {"link_rate", 300.0f, 115200.0f, 4800.0f, false, 263},
    {"link_share", 0.05f, 1.0f, 0.75f, false, 264},
    {"system_id", 1.0f, 250.0f, 1.0f, true, 265},
    {"sign", 0.0f, 1.0f, 0.0f, true, 266},
};

inline constexpr std::uint8_t file_0[] = {
    123, 34, 118, 101, 114, 115, 105, 111, 110, 34, 58, 49, 44, 34, 109, 101, 116, 97, 100, 97, 116, 97, 84, 121,
    112, 101, 115, 34, 58, 91, 123, 34, 116, 121, 112, 101, 34, 58, 49, 44, 34, 117, 114, 105, 34, 58, 34, 109,
    102, 116, 112, 58, 47, 47, 112, 97, 114, 97, 109, 101, 116, 101, 114, 115, 46, 106, 115, 111, 110, 46, 120, 122,
    34, 44, 34, 102, 105, 108, 101, 67, 114, 99, 34, 58, 49, 51, 53, 55, 55, 54, 50, 54, 50, 125, 93, 125,
};
inline constexpr std::uint8_t file_1[] = {
    253, 55, 122, 88, 90, 0, 0, 1, 105, 34, 222, 54, 2, 0, 33, 1, 28, 0, 0, 0, 16, 207, 88, 204,
    224, 61, 207, 8, 208, 93, 0, 61, 136, 138, 198, 148, 83, 144, 134, 166, 99, 125, 37, 52, 16, 60, 26, 62,
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
    25, 117, 204, 51, 142, 58, 246, 44, 164, 184, 145, 252, 120, 70, 39, 208, 68, 58, 139, 46, 2, 245, 225, 204,
    206, 232, 129, 21, 252, 4, 7, 220, 85, 161, 228, 123, 227, 215, 126, 80, 169, 226, 241, 255, 24, 167, 80, 66,
    94, 212, 186, 138, 56, 206, 153, 107, 164, 212, 77, 69, 3, 78, 196, 222, 2, 174, 137, 186, 154, 20, 130, 241,
    181, 121, 185, 13, 32, 47, 174, 214, 101, 90, 43, 29, 242, 210, 193, 204, 34, 13, 161, 88, 83, 91, 64, 143,
    17, 7, 174, 29, 152, 87, 166, 73, 145, 206, 57, 210, 64, 23, 174, 244, 121, 20, 7, 165, 215, 113, 223, 54,
    248, 223, 250, 172, 60, 65, 150, 141, 246, 95, 142, 176, 219, 231, 65, 87, 192, 228, 86, 84, 210, 104, 189, 201,
    57, 184, 163, 166, 92, 220, 58, 179, 126, 255, 73, 17, 90, 129, 246, 39, 225, 255, 26, 229, 148, 88, 134, 150,
    255, 192, 130, 29, 111, 73, 143, 44, 206, 148, 165, 158, 196, 196, 240, 99, 213, 118, 107, 224, 215, 97, 110, 63,
    28, 236, 181, 109, 28, 117, 126, 139, 119, 53, 205, 228, 62, 40, 104, 98, 93, 74, 46, 209, 189, 104, 207, 153,
    222, 146, 156, 132, 144, 1, 249, 170, 101, 240, 84, 199, 220, 60, 233, 31, 19, 54, 231, 108, 251, 171, 82, 13,
    230, 72, 84, 63, 10, 173, 63, 22, 243, 56, 85, 6, 7, 232, 159, 208, 164, 195, 35, 58, 165, 137, 25, 119,
    44, 69, 41, 138, 135, 57, 177, 115, 152, 128, 174, 23, 177, 197, 33, 173, 255, 137, 162, 183, 60, 234, 106, 28,
    33, 107, 155, 174, 5, 8, 254, 131, 227, 30, 205, 0, 76, 118, 49, 15, 42, 216, 51, 63, 110, 213, 136, 245,
    156, 129, 189, 177, 57, 220, 47, 77, 5, 205, 239, 9, 31, 244, 79, 25, 56, 202, 210, 38, 132, 17, 67, 159,
    140, 40, 51, 162, 138, 131, 0, 173, 16, 166, 151, 98, 224, 117, 3, 55, 194, 129, 168, 92, 199, 40, 24, 96,
    15, 17, 16, 5, 75, 199, 86, 26, 203, 189, 68, 253, 53, 130, 18, 201, 213, 1, 221, 140, 37, 61, 222, 47,
    129, 53, 48, 187, 85, 41, 218, 43, 78, 44, 66, 48, 161, 239, 97, 125, 30, 137, 204, 38, 225, 219, 82, 94,
    33, 44, 49, 62, 102, 11, 72, 6, 166, 102, 156, 178, 221, 98, 251, 30, 248, 131, 118, 224, 208, 247, 245, 95,
    170, 109, 14, 74, 2, 101, 149, 6, 172, 185, 217, 66, 164, 0, 199, 131, 231, 17, 145, 66, 90, 7, 84, 243,
    185, 152, 15, 121, 167, 66, 83, 204, 78, 221, 213, 175, 230, 67, 163, 124, 211, 53, 127, 20, 247, 223, 40, 251,
    151, 130, 83, 142, 229, 224, 88, 40, 223, 172, 73, 6, 45, 74, 97, 15, 55, 35, 218, 235, 32, 187, 26, 93,
    170, 9, 102, 38, 35, 164, 122, 5, 41, 47, 193, 73, 102, 103, 172, 17, 141, 231, 232, 241, 169, 137, 70, 37,
    1, 96, 212, 124, 77, 170, 59, 45, 140, 165, 192, 74, 110, 199, 118, 68, 17, 138, 39, 190, 155, 88, 202, 199,
    44, 76, 222, 32, 125, 104, 241, 27, 13, 75, 12, 152, 62, 52, 36, 26, 190, 235, 143, 217, 250, 93, 2, 48,
    66, 72, 185, 107, 198, 84, 138, 54, 232, 144, 29, 183, 55, 160, 65, 194, 34, 151, 96, 2, 78, 158, 130, 221,
    158, 24, 82, 25, 159, 128, 38, 153, 36, 198, 228, 236, 169, 244, 240, 123, 71, 10, 241, 158, 11, 197, 111, 47,
    197, 36, 99, 245, 93, 208, 189, 156, 82, 179, 254, 73, 76, 128, 56, 191, 97, 63, 182, 176, 76, 13, 205, 242,
    31, 59, 43, 67, 169, 63, 33, 134, 224, 82, 197, 177, 88, 49, 200, 38, 20, 30, 132, 34, 123, 21, 156, 120,
    231, 251, 89, 58, 17, 120, 10, 200, 167, 103, 23, 134, 70, 149, 119, 169, 106, 103, 85, 104, 172, 46, 222, 56,
    225, 30, 237, 66, 159, 32, 108, 4, 101, 208, 13, 137, 217, 211, 3, 78, 40, 34, 215, 226, 144, 246, 19, 143,
    33, 200, 16, 64, 6, 90, 98, 33, 46, 212, 217, 170, 132, 59, 224, 162, 177, 190, 98, 107, 168, 54, 238, 59,
    198, 185, 215, 143, 100, 40, 171, 197, 84, 198, 137, 91, 30, 90, 103, 130, 34, 10, 120, 77, 29, 72, 174, 166,
    158, 233, 153, 54, 190, 115, 90, 99, 116, 233, 17, 217, 68, 75, 222, 221, 233, 91, 92, 171, 198, 178, 154, 146,
    58, 58, 130, 163, 152, 210, 176, 107, 243, 115, 22, 61, 102, 150, 103, 220, 36, 191, 224, 28, 211, 188, 31, 51,
    79, 101, 177, 130, 90, 105, 110, 246, 2, 114, 167, 35, 114, 197, 78, 23, 6, 250, 27, 119, 41, 74, 158, 0,
    219, 235, 205, 182, 127, 109, 58, 63, 219, 188, 197, 1, 164, 159, 58, 206, 10, 149, 180, 175, 132, 246, 13, 111,
    172, 135, 191, 18, 234, 200, 25, 46, 33, 36, 39, 20, 239, 44, 130, 245, 18, 142, 194, 63, 246, 90, 98, 206,
    138, 26, 115, 31, 23, 133, 38, 149, 30, 250, 179, 45, 209, 32, 105, 89, 210, 230, 94, 85, 78, 77, 224, 94,
    162, 12, 182, 66, 244, 129, 153, 112, 190, 237, 226, 10, 131, 117, 241, 61, 88, 141, 167, 238, 223, 197, 105, 211,
    29, 243, 177, 182, 128, 48, 159, 41, 143, 217, 185, 101, 76, 52, 59, 30, 178, 49, 100, 28, 82, 96, 84, 73,
    240, 100, 101, 167, 28, 230, 4, 71, 26, 9, 143, 24, 128, 19, 92, 6, 125, 9, 246, 254, 3, 104, 235, 212,
    160, 206, 164, 235, 72, 112, 138, 16, 177, 28, 195, 100, 18, 63, 254, 128, 194, 161, 152, 167, 223, 190, 65, 91,
    30, 115, 74, 14, 34, 44, 214, 133, 4, 86, 218, 72, 1, 71, 126, 250, 117, 131, 93, 69, 117, 248, 157, 14,
    26, 87, 103, 48, 28, 253, 12, 23, 253, 246, 163, 234, 224, 239, 91, 30, 81, 75, 203, 11, 161, 135, 56, 119,
    31, 161, 30, 92, 82, 206, 227, 241, 62, 241, 16, 139, 55, 223, 94, 135, 19, 188, 52, 207, 250, 27, 100, 174,
    160, 134, 158, 207, 166, 120, 137, 26, 217, 176, 209, 19, 20, 66, 59, 31, 6, 170, 7, 223, 135, 50, 36, 202,
    238, 222, 35, 130, 64, 161, 56, 115, 117, 235, 236, 166, 5, 209, 127, 157, 185, 113, 133, 82, 253, 239, 28, 242,
    185, 110, 123, 18, 25, 10, 230, 136, 141, 224, 194, 142, 247, 2, 54, 185, 127, 111, 132, 47, 199, 208, 222, 190,
    29, 71, 225, 0, 116, 182, 13, 151, 151, 223, 57, 168, 63, 47, 211, 20, 98, 39, 244, 133, 254, 171, 189, 80,
    80, 144, 240, 0, 69, 28, 253, 31, 114, 218, 40, 12, 133, 255, 248, 90, 137, 118, 69, 255, 252, 139, 177, 218,
    87, 67, 175, 127, 169, 215, 180, 42, 180, 31, 21, 18, 7, 164, 139, 175, 42, 7, 94, 133, 21, 150, 25, 33,
    171, 185, 172, 155, 110, 159, 29, 152, 81, 58, 6, 218, 134, 54, 169, 71, 227, 62, 188, 122, 247, 143, 104, 92,
    106, 9, 135, 108, 18, 220, 249, 79, 12, 249, 127, 187, 54, 97, 224, 139, 131, 136, 63, 165, 120, 39, 102, 35,
    177, 164, 70, 208, 209, 26, 129, 6, 125, 220, 179, 208, 172, 217, 229, 238, 39, 206, 150, 89, 54, 109, 2, 152,
    17, 148, 92, 200, 222, 60, 221, 122, 67, 48, 166, 247, 66, 134, 22, 124, 61, 90, 135, 121, 157, 188, 136, 71,
    75, 125, 99, 236, 186, 132, 79, 109, 248, 136, 230, 227, 86, 3, 106, 113, 138, 58, 178, 38, 21, 19, 118, 207,
    198, 183, 113, 45, 5, 245, 68, 86, 173, 161, 180, 82, 205, 62, 47, 101, 24, 46, 254, 93, 156, 88, 211, 24,
    145, 189, 119, 51, 115, 135, 132, 193, 106, 113, 179, 253, 86, 90, 42, 204, 115, 33, 55, 150, 208, 13, 40, 211,
    20, 28, 248, 153, 208, 241, 81, 197, 178, 207, 176, 16, 181, 168, 126, 34, 60, 178, 150, 25, 209, 230, 128, 131,
    253, 137, 113, 238, 68, 109, 140, 250, 222, 23, 18, 4, 15, 246, 138, 27, 253, 50, 107, 164, 24, 37, 199, 78,
    94, 175, 240, 122, 240, 22, 254, 186, 118, 192, 119, 68, 165, 138, 187, 194, 158, 118, 123, 65, 138, 227, 123, 190,
    44, 34, 96, 135, 199, 248, 162, 31, 47, 243, 72, 202, 174, 75, 41, 205, 203, 121, 249, 19, 79, 244, 129, 86,
    198, 5, 244, 125, 62, 59, 10, 0, 86, 208, 49, 235, 0, 1, 232, 17, 208, 123, 0, 0, 40, 205, 50, 26,
    62, 48, 13, 139, 2, 0, 0, 0, 0, 1, 89, 90,
};

inline constexpr FileInfo files[] = {
    {"general.json", file_0, 96, 0x45626a61},
    {"parameters.json.xz", file_1, 2316, 0x0817c806},
};

inline constexpr Description description = {
    "hypertuna", 2, 3, values, 267, parameters, 90, 0x8593168b, files, 2};

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
