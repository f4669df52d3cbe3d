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
    10.454144f,  // controller rate[0]
    1.5708f,  // controller bend_range[0]
    0.31933653f,  // controller bend_step[0]
    3.3901567f,  // controller safe_static[0]
    0.2782882f,  // controller safe_rate[0]
    4.4173307f,  // controller safe_square[0]
    0.0f,  // controller direct[1]
    0.65345126f,  // controller reach[1]
    0.54454273f,  // controller amplitude[1]
    18.772001f,  // controller rate[1]
    1.5708f,  // controller bend_range[1]
    0.54743403f,  // controller bend_step[1]
    2.0624087f,  // controller safe_static[1]
    0.18228951f,  // controller safe_rate[1]
    3.0374575f,  // controller safe_square[1]
    -0.19821355f,  // controller map_low[0]
    0.19821355f,  // controller map_high[0]
    0.40777695f,  // controller map[0]
    -0.5611377f,  // controller map[1]
    -0.30046824f,  // controller map[2]
    0.28427202f,  // controller map[3]
    0.9725682f,  // controller map[4]
    0.4109508f,  // controller map[5]
    7.5f,  // controller servo_speed[0]
    804864.94f,  // controller servo_stall[0]
    60000.0f,  // controller fill[0]
    2.5105754e-07f,  // controller compliance[0]
    125784.45f,  // controller line[0]
    44569.98f,  // controller hammer[0]
    -0.19821355f,  // controller map_low[1]
    0.19821355f,  // controller map_high[1]
    0.40777695f,  // controller map[6]
    -0.5611377f,  // controller map[7]
    -0.30046824f,  // controller map[8]
    0.28427202f,  // controller map[9]
    0.9725682f,  // controller map[10]
    0.4109508f,  // controller map[11]
    7.5f,  // controller servo_speed[1]
    804864.94f,  // controller servo_stall[1]
    60000.0f,  // controller fill[1]
    2.5105754e-07f,  // controller compliance[1]
    125784.45f,  // controller line[1]
    44569.98f,  // controller hammer[1]
    -0.37900174f,  // controller map_low[2]
    0.37900174f,  // controller map_high[2]
    0.14362517f,  // controller map[12]
    -0.14768995f,  // controller map[13]
    -0.05550814f,  // controller map[14]
    0.056010593f,  // controller map[15]
    0.27189153f,  // controller map[16]
    0.31619674f,  // controller map[17]
    7.5f,  // controller servo_speed[2]
    804864.94f,  // controller servo_stall[2]
    60000.0f,  // controller fill[2]
    1.3290689e-07f,  // controller compliance[2]
    314461.12f,  // controller line[2]
    70471.33f,  // controller hammer[2]
    -0.37900174f,  // controller map_low[3]
    0.37900174f,  // controller map_high[3]
    0.14362517f,  // controller map[18]
    -0.14768995f,  // controller map[19]
    -0.05550814f,  // controller map[20]
    0.056010593f,  // controller map[21]
    0.27189153f,  // controller map[22]
    0.31619674f,  // controller map[23]
    7.5f,  // controller servo_speed[3]
    804864.94f,  // controller servo_stall[3]
    60000.0f,  // controller fill[3]
    1.3290689e-07f,  // controller compliance[3]
    314461.12f,  // controller line[3]
    70471.33f,  // controller hammer[3]
    250000.0f,  // controller pressure_soft[0]
    300000.0f,  // controller pressure_hard[0]
    -100000.0f,  // controller pressure_low[0]
    500000.0f,  // controller pressure_high[0]
    200000.0f,  // controller pressure_step[0]
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
    0.298f,  // pilot speed[0]
    2.0f,  // pilot frequency[0]
    0.27925268f,  // pilot swing[0]
    0.0f,  // pilot lag[0]
    0.43633232f,  // pilot swing[1]
    0.0f,  // pilot lag[1]
    0.347f,  // pilot speed[1]
    3.0f,  // pilot frequency[1]
    0.27925268f,  // pilot swing[2]
    0.0f,  // pilot lag[2]
    0.43633232f,  // pilot swing[3]
    0.0f,  // pilot lag[3]
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
    0.108024694f,  // pilot battery_drop[0]
    15525.11f,  // pilot endurance[0]
    30.0f,  // pilot overhead[0]
    32768.0f,  // calibration bend_zero[0]
    32768.0f,  // calibration bend_zero[1]
    5.9921265e-05f,  // calibration bend_scale[0]
    5.9921265e-05f,  // calibration bend_scale[1]
    15291.733f,  // calibration pressure_zero[0]
    15291.733f,  // calibration pressure_zero[1]
    15291.733f,  // calibration pressure_zero[2]
    15291.733f,  // calibration pressure_zero[3]
    11.444092f,  // calibration pressure_scale[0]
    11.444092f,  // calibration pressure_scale[1]
    11.444092f,  // calibration pressure_scale[2]
    11.444092f,  // calibration pressure_scale[3]
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
    {"pressure_soft", 125000.0f, 250000.0f, 250000.0f, false, 88},
    {"pressure_hard", 150000.0f, 300000.0f, 300000.0f, false, 89},
    {"frequency_max", 0.8f, 8.0f, 8.0f, false, 101},
    {"fin_max", 0.0f, 0.7853982f, 0.7853982f, false, 102},
    {"voltage_low", 12.8f, 15.360001f, 12.8f, false, 98},
    {"timeout_ticks", 10.0f, 50.0f, 50.0f, true, 103},
    {"pulse_center", 0.00135f, 0.00165f, 0.0015f, false, 104},
    {"pulse_per_rad", 0.00050960004f, 0.00079625f, 0.000637f, false, 105},
    {"pulse_min", 0.0008f, 0.0011999999f, 0.0008f, false, 106},
    {"pulse_max", 0.00165f, 0.0022f, 0.0022f, false, 107},
    {"slew", 0.015000001f, 0.15f, 0.15f, false, 108},
    {"heading_rate", 0.2f, 0.8f, 0.4f, false, 157},
    {"heading_integral", 0.05f, 0.2f, 0.1f, false, 160},
    {"rate_gain", 0.25f, 1.0f, 0.5f, false, 159},
    {"turn_max", 0.14835298f, 0.5934119f, 0.29670596f, false, 158},
    {"curvature", 0.55917656f, 2.2367063f, 1.1183531f, false, 156},
    {"lookahead", 2.0f, 8.0f, 4.0f, false, 162},
    {"depth_lookahead", 0.75f, 3.0f, 1.5f, false, 163},
    {"depth_integral", 0.025f, 0.1f, 0.05f, false, 168},
    {"climb_lead", 1.0f, 4.0f, 2.0f, false, 166},
    {"climb_gain", 0.3f, 1.2f, 0.6f, false, 167},
    {"pitch_damping", 0.2f, 0.8f, 0.4f, false, 170},
    {"speed_min", 0.05f, 0.2f, 0.1f, false, 161},
    {"surface_depth", 0.06f, 0.24f, 0.12f, false, 172},
    {"fence_margin", 1.5f, 6.0f, 3.0f, false, 173},
    {"error_max", 6.0f, 24.0f, 12.0f, false, 174},
    {"fix_timeout", 30.0f, 120.0f, 60.0f, false, 181},
    {"bend_zero_0", -65536.0f, 65536.0f, 32768.0f, false, 198},
    {"bend_zero_1", -65536.0f, 65536.0f, 32768.0f, false, 199},
    {"bend_scale_0", 1.4980316e-05f, 0.00023968506f, 5.9921265e-05f, false, 200},
    {"bend_scale_1", 1.4980316e-05f, 0.00023968506f, 5.9921265e-05f, false, 201},
    {"pressure_zero_0", -65536.0f, 65536.0f, 15291.733f, false, 202},
    {"pressure_zero_1", -65536.0f, 65536.0f, 15291.733f, false, 203},
    {"pressure_zero_2", -65536.0f, 65536.0f, 15291.733f, false, 204},
    {"pressure_zero_3", -65536.0f, 65536.0f, 15291.733f, false, 205},
    {"pressure_scale_0", 2.861023f, 45.776367f, 11.444092f, false, 206},
    {"pressure_scale_1", 2.861023f, 45.776367f, 11.444092f, false, 207},
    {"pressure_scale_2", 2.861023f, 45.776367f, 11.444092f, false, 208},
    {"pressure_scale_3", 2.861023f, 45.776367f, 11.444092f, false, 209},
    {"current_zero_0", -65536.0f, 65536.0f, 32768.0f, false, 210},
    {"current_zero_1", -65536.0f, 65536.0f, 32768.0f, false, 211},
    {"current_zero_2", -65536.0f, 65536.0f, 32768.0f, false, 212},
    {"current_zero_3", -65536.0f, 65536.0f, 32768.0f, false, 213},
    {"current_scale_0", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 214},
    {"current_scale_1", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 215},
    {"current_scale_2", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 216},
    {"current_scale_3", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 217},
    {"voltage_zero", -65536.0f, 65536.0f, 6553.6f, false, 230},
    {"voltage_scale", 9.536743e-05f, 0.0015258789f, 0.00038146973f, false, 231},
    {"rate_zero_0", -327.68f, 327.68f, 0.0f, false, 218},
    {"rate_zero_1", -327.68f, 327.68f, 0.0f, false, 219},
    {"rate_zero_2", -327.68f, 327.68f, 0.0f, false, 220},
    {"rate_scale_0", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 221},
    {"rate_scale_1", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 222},
    {"rate_scale_2", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 223},
    {"accel_zero_0", -327.68f, 327.68f, 0.0f, false, 224},
    {"accel_zero_1", -327.68f, 327.68f, 0.0f, false, 225},
    {"accel_zero_2", -327.68f, 327.68f, 0.0f, false, 226},
    {"accel_scale_0", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 227},
    {"accel_scale_1", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 228},
    {"accel_scale_2", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 229},
    {"depth_zero", 8106.0f, 12159.0f, 10132.5f, false, 232},
    {"depth_scale", 0.00091743114f, 0.0011213047f, 0.001019368f, false, 233},
    {"field_zero_0", -32768.0f, 32768.0f, 0.0f, false, 234},
    {"field_zero_1", -32768.0f, 32768.0f, 0.0f, false, 235},
    {"field_zero_2", -32768.0f, 32768.0f, 0.0f, false, 236},
    {"field_scale_0", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 237},
    {"field_scale_1", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 238},
    {"field_scale_2", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 239},
    {"servo_trim_0", -0.0002f, 0.0002f, 0.0f, false, 240},
    {"servo_trim_1", -0.0002f, 0.0002f, 0.0f, false, 241},
    {"servo_trim_2", -0.0002f, 0.0002f, 0.0f, false, 242},
    {"servo_trim_3", -0.0002f, 0.0002f, 0.0f, false, 243},
    {"servo_trim_4", -0.0002f, 0.0002f, 0.0f, false, 244},
    {"servo_trim_5", -0.0002f, 0.0002f, 0.0f, false, 245},
    {"manual_timeout", 0.1f, 1.0f, 1.0f, false, 246},
    {"link_timeout", 1.0f, 10.0f, 5.0f, false, 247},
    {"home_timeout", 12.0f, 600.0f, 60.0f, false, 248},
    {"voltage_empty", 12.0f, 14.4f, 12.0f, false, 249},
    {"tilt_max", 0.4330127f, 0.8660254f, 0.8660254f, false, 251},
    {"rise_depth", 0.3f, 6.0f, 1.5f, false, 254},
    {"depth_max", 0.5f, 10.0f, 10.0f, false, 255},
    {"link_rate", 300.0f, 115200.0f, 4800.0f, false, 256},
    {"link_share", 0.05f, 1.0f, 0.75f, false, 257},
    {"system_id", 1.0f, 250.0f, 1.0f, true, 258},
    {"sign", 0.0f, 1.0f, 0.0f, true, 259},
};

inline constexpr std::uint8_t file_0[] = {
    123, 34, 118, 101, 114, 115, 105, 111, 110, 34, 58, 49, 44, 34, 109, 101, 116, 97, 100, 97, 116, 97, 84, 121,
    112, 101, 115, 34, 58, 91, 123, 34, 116, 121, 112, 101, 34, 58, 49, 44, 34, 117, 114, 105, 34, 58, 34, 109,
    102, 116, 112, 58, 47, 47, 112, 97, 114, 97, 109, 101, 116, 101, 114, 115, 46, 106, 115, 111, 110, 46, 120, 122,
    34, 44, 34, 102, 105, 108, 101, 67, 114, 99, 34, 58, 52, 49, 54, 52, 54, 55, 55, 53, 54, 48, 125, 93,
    125,
};
inline constexpr std::uint8_t file_1[] = {
    253, 55, 122, 88, 90, 0, 0, 1, 105, 34, 222, 54, 2, 0, 33, 1, 28, 0, 0, 0, 16, 207, 88, 204,
    224, 60, 170, 8, 125, 93, 0, 61, 136, 138, 198, 148, 83, 144, 134, 166, 99, 125, 37, 52, 16, 60, 26, 62,
    243, 151, 185, 7, 52, 114, 247, 250, 90, 5, 43, 183, 160, 78, 94, 58, 111, 84, 221, 30, 57, 49, 177, 11,
    245, 190, 43, 198, 213, 24, 159, 252, 202, 16, 164, 92, 55, 139, 166, 177, 171, 182, 103, 160, 21, 192, 135, 185,
    132, 57, 141, 107, 167, 85, 156, 144, 230, 108, 14, 237, 234, 132, 213, 221, 64, 145, 235, 42, 187, 22, 160, 2,
    85, 117, 97, 96, 155, 185, 140, 24, 201, 117, 196, 74, 127, 68, 82, 143, 7, 48, 111, 5, 201, 87, 137, 246,
    214, 244, 176, 160, 36, 255, 50, 178, 199, 80, 87, 180, 239, 215, 123, 182, 14, 211, 208, 194, 1, 190, 110, 170,
    224, 185, 77, 119, 184, 51, 92, 175, 102, 173, 111, 183, 134, 18, 226, 162, 165, 11, 204, 152, 198, 23, 99, 114,
    163, 189, 194, 184, 245, 206, 234, 167, 132, 92, 38, 207, 174, 130, 145, 247, 65, 34, 84, 38, 134, 77, 20, 215,
    197, 27, 11, 196, 83, 166, 231, 147, 251, 125, 147, 80, 163, 140, 214, 199, 123, 64, 183, 63, 202, 188, 78, 105,
    136, 241, 57, 7, 146, 100, 160, 21, 134, 230, 47, 68, 120, 87, 188, 110, 130, 113, 62, 154, 180, 95, 204, 124,
    248, 167, 100, 77, 121, 205, 145, 181, 206, 144, 172, 217, 117, 84, 20, 19, 62, 47, 63, 75, 70, 179, 225, 23,
    18, 225, 194, 187, 27, 139, 135, 162, 215, 184, 60, 238, 198, 163, 40, 199, 125, 167, 241, 106, 196, 35, 188, 4,
    27, 133, 66, 192, 49, 107, 26, 19, 190, 18, 172, 244, 164, 79, 71, 211, 2, 144, 0, 55, 141, 188, 229, 25,
    140, 123, 61, 42, 255, 27, 20, 236, 203, 27, 89, 86, 27, 208, 125, 133, 82, 217, 168, 72, 35, 57, 17, 150,
    54, 22, 244, 47, 150, 218, 71, 217, 254, 241, 217, 74, 231, 165, 142, 102, 140, 26, 246, 39, 217, 190, 87, 184,
    8, 173, 46, 159, 161, 11, 25, 173, 7, 112, 222, 10, 90, 149, 203, 36, 181, 35, 242, 177, 142, 250, 173, 44,
    58, 43, 91, 38, 213, 2, 254, 32, 118, 61, 116, 151, 38, 181, 28, 160, 100, 41, 84, 175, 77, 0, 122, 155,
    229, 115, 160, 239, 203, 190, 118, 227, 88, 112, 239, 21, 48, 106, 250, 91, 50, 213, 134, 131, 23, 78, 214, 225,
    202, 144, 3, 99, 89, 49, 43, 153, 222, 255, 63, 201, 95, 220, 123, 39, 247, 52, 114, 108, 225, 62, 219, 185,
    172, 141, 30, 69, 174, 244, 152, 139, 139, 12, 145, 71, 178, 187, 125, 208, 46, 90, 0, 85, 204, 54, 238, 107,
    170, 164, 52, 32, 79, 209, 46, 29, 141, 249, 164, 105, 40, 10, 162, 79, 70, 196, 36, 79, 165, 123, 117, 167,
    49, 232, 86, 176, 64, 98, 244, 192, 247, 2, 180, 44, 218, 12, 85, 85, 65, 39, 202, 171, 228, 237, 60, 164,
    75, 248, 46, 7, 245, 175, 18, 244, 109, 181, 13, 175, 208, 224, 41, 193, 8, 2, 169, 248, 52, 173, 104, 66,
    187, 177, 87, 8, 199, 84, 231, 227, 145, 109, 93, 40, 165, 186, 205, 182, 253, 191, 37, 220, 231, 150, 126, 238,
    118, 36, 203, 243, 134, 187, 13, 45, 86, 170, 65, 49, 50, 158, 211, 65, 219, 43, 97, 56, 118, 45, 142, 227,
    86, 108, 153, 93, 38, 90, 155, 7, 105, 133, 127, 114, 51, 184, 119, 119, 241, 153, 215, 134, 199, 248, 240, 83,
    122, 201, 226, 193, 47, 230, 188, 29, 139, 27, 92, 72, 39, 44, 253, 85, 106, 197, 219, 10, 243, 133, 172, 197,
    93, 135, 173, 51, 198, 224, 88, 240, 71, 169, 224, 154, 33, 235, 103, 18, 245, 240, 162, 209, 63, 191, 201, 26,
    178, 255, 206, 154, 76, 140, 138, 220, 79, 172, 74, 201, 156, 190, 132, 69, 57, 226, 246, 69, 89, 155, 58, 8,
    147, 176, 87, 140, 116, 82, 8, 142, 217, 192, 111, 18, 66, 2, 55, 82, 190, 125, 53, 37, 3, 76, 95, 65,
    188, 198, 239, 105, 230, 217, 236, 79, 79, 244, 188, 51, 180, 6, 212, 47, 191, 163, 246, 181, 29, 213, 150, 188,
    155, 11, 83, 158, 155, 110, 16, 44, 159, 116, 9, 217, 88, 192, 10, 79, 151, 67, 95, 14, 16, 60, 43, 229,
    121, 133, 39, 67, 236, 249, 196, 19, 23, 175, 76, 54, 152, 30, 101, 1, 239, 156, 157, 123, 66, 142, 174, 145,
    150, 198, 232, 38, 115, 197, 102, 117, 201, 189, 125, 198, 112, 160, 194, 246, 172, 18, 6, 156, 71, 110, 196, 41,
    237, 134, 1, 244, 202, 166, 116, 243, 115, 169, 168, 167, 253, 184, 125, 61, 189, 109, 132, 79, 182, 95, 55, 172,
    0, 110, 22, 97, 117, 10, 219, 178, 15, 132, 1, 251, 88, 16, 185, 186, 61, 173, 141, 157, 8, 74, 200, 154,
    24, 8, 251, 230, 229, 159, 78, 150, 222, 104, 39, 232, 122, 127, 228, 45, 44, 75, 143, 168, 208, 52, 149, 20,
    209, 215, 40, 67, 201, 101, 205, 210, 128, 184, 199, 216, 96, 96, 154, 59, 251, 170, 92, 90, 71, 121, 226, 81,
    245, 171, 172, 173, 202, 228, 9, 37, 5, 167, 39, 30, 163, 4, 14, 214, 176, 194, 16, 207, 233, 80, 79, 172,
    39, 145, 137, 151, 148, 92, 107, 254, 196, 255, 35, 222, 0, 84, 154, 4, 17, 197, 190, 235, 71, 103, 118, 80,
    242, 59, 111, 36, 94, 145, 89, 103, 152, 252, 68, 31, 10, 131, 167, 160, 184, 43, 117, 67, 213, 94, 59, 124,
    7, 171, 78, 242, 211, 115, 144, 78, 156, 29, 77, 48, 182, 42, 216, 118, 72, 20, 104, 17, 66, 245, 190, 149,
    128, 227, 151, 229, 130, 143, 66, 109, 86, 231, 58, 87, 99, 177, 232, 61, 165, 12, 34, 197, 67, 189, 225, 129,
    0, 1, 100, 147, 46, 165, 45, 132, 146, 30, 69, 90, 118, 146, 39, 136, 32, 100, 30, 15, 246, 94, 211, 161,
    36, 68, 185, 34, 142, 173, 200, 113, 181, 13, 13, 254, 174, 168, 26, 229, 140, 171, 168, 94, 22, 42, 148, 134,
    67, 212, 39, 192, 42, 88, 238, 111, 202, 165, 184, 134, 109, 192, 101, 142, 109, 13, 65, 130, 178, 183, 26, 162,
    149, 22, 149, 236, 21, 187, 169, 65, 29, 239, 131, 193, 38, 203, 241, 225, 200, 75, 203, 31, 72, 190, 57, 116,
    49, 7, 176, 143, 65, 64, 182, 31, 5, 57, 104, 196, 252, 237, 85, 235, 14, 23, 36, 147, 194, 116, 16, 171,
    76, 249, 78, 164, 240, 226, 249, 232, 171, 226, 145, 20, 188, 139, 23, 209, 70, 116, 232, 5, 93, 226, 200, 173,
    70, 47, 131, 58, 62, 69, 124, 198, 103, 6, 61, 142, 135, 107, 250, 78, 20, 147, 99, 181, 4, 124, 49, 90,
    5, 169, 129, 193, 137, 235, 45, 5, 83, 65, 29, 122, 183, 104, 116, 30, 138, 137, 162, 27, 39, 150, 239, 233,
    69, 238, 229, 179, 221, 164, 59, 194, 130, 174, 121, 141, 29, 214, 167, 200, 225, 106, 124, 158, 96, 141, 38, 15,
    101, 208, 181, 68, 255, 94, 30, 170, 238, 129, 252, 241, 83, 8, 251, 39, 180, 79, 73, 219, 30, 6, 125, 192,
    41, 157, 21, 100, 140, 36, 189, 136, 65, 19, 74, 212, 157, 196, 220, 84, 74, 5, 7, 67, 212, 165, 11, 223,
    201, 187, 1, 94, 43, 171, 85, 84, 153, 23, 19, 46, 54, 160, 124, 67, 105, 148, 201, 196, 75, 22, 121, 113,
    89, 188, 107, 108, 57, 87, 213, 14, 165, 186, 74, 90, 79, 230, 30, 180, 104, 228, 22, 22, 111, 160, 201, 134,
    136, 121, 121, 251, 156, 54, 51, 99, 152, 211, 131, 59, 159, 116, 248, 112, 99, 236, 87, 82, 138, 97, 100, 31,
    180, 79, 167, 104, 21, 30, 173, 61, 109, 20, 154, 65, 65, 68, 201, 137, 93, 2, 112, 29, 204, 201, 13, 240,
    99, 159, 72, 184, 96, 91, 182, 221, 51, 169, 14, 48, 1, 221, 75, 56, 254, 198, 225, 29, 153, 176, 170, 10,
    143, 126, 21, 126, 21, 191, 123, 217, 33, 112, 28, 54, 243, 85, 174, 152, 56, 170, 2, 169, 166, 225, 100, 92,
    149, 42, 143, 61, 222, 203, 24, 163, 23, 54, 63, 248, 5, 107, 19, 173, 19, 230, 80, 238, 39, 82, 107, 249,
    70, 237, 60, 131, 240, 225, 94, 17, 186, 36, 48, 167, 102, 209, 32, 249, 122, 26, 226, 104, 189, 22, 189, 12,
    122, 122, 170, 207, 76, 236, 106, 127, 149, 101, 88, 82, 45, 197, 134, 252, 29, 200, 88, 168, 167, 155, 118, 153,
    188, 241, 255, 175, 165, 39, 111, 17, 120, 123, 201, 86, 197, 50, 220, 151, 115, 2, 167, 225, 126, 123, 48, 45,
    120, 124, 228, 130, 31, 213, 136, 217, 254, 92, 10, 62, 113, 142, 130, 110, 216, 104, 29, 35, 235, 143, 52, 136,
    69, 238, 58, 41, 43, 169, 184, 109, 61, 205, 145, 197, 139, 248, 137, 90, 155, 76, 217, 92, 252, 145, 121, 209,
    131, 254, 111, 226, 229, 151, 169, 137, 166, 138, 96, 124, 62, 239, 22, 3, 194, 126, 62, 18, 91, 175, 139, 30,
    34, 137, 30, 239, 61, 200, 86, 64, 218, 25, 108, 35, 113, 47, 16, 189, 242, 85, 64, 113, 21, 201, 183, 230,
    204, 127, 166, 117, 121, 138, 111, 141, 51, 70, 52, 46, 153, 78, 133, 42, 73, 254, 137, 36, 79, 213, 189, 115,
    87, 124, 130, 95, 92, 104, 207, 198, 38, 190, 22, 229, 142, 80, 56, 15, 215, 193, 119, 70, 127, 46, 30, 192,
    226, 226, 110, 28, 177, 252, 181, 155, 39, 208, 39, 177, 21, 30, 15, 28, 247, 214, 200, 144, 159, 163, 200, 110,
    192, 203, 42, 9, 184, 241, 58, 154, 130, 15, 67, 159, 217, 163, 44, 45, 227, 149, 11, 131, 114, 5, 197, 215,
    80, 157, 213, 21, 235, 197, 243, 68, 103, 231, 143, 101, 56, 25, 56, 141, 235, 203, 192, 225, 59, 242, 137, 48,
    54, 141, 115, 47, 131, 11, 178, 199, 97, 96, 61, 184, 19, 19, 7, 194, 87, 19, 188, 237, 0, 98, 68, 211,
    200, 236, 6, 188, 208, 171, 223, 34, 125, 112, 232, 86, 248, 237, 88, 67, 220, 208, 210, 124, 133, 160, 10, 124,
    200, 183, 98, 216, 129, 186, 130, 41, 75, 201, 37, 208, 178, 116, 26, 22, 244, 67, 116, 208, 143, 181, 80, 7,
    50, 112, 241, 233, 31, 43, 173, 85, 108, 101, 231, 54, 197, 213, 64, 100, 45, 239, 165, 202, 83, 47, 122, 32,
    253, 46, 158, 150, 184, 114, 141, 89, 114, 251, 254, 198, 214, 2, 206, 214, 35, 195, 168, 187, 242, 252, 27, 117,
    211, 239, 118, 77, 152, 227, 238, 213, 159, 246, 52, 105, 28, 101, 1, 149, 68, 173, 114, 26, 45, 171, 255, 85,
    225, 128, 222, 252, 194, 59, 49, 54, 141, 3, 22, 89, 30, 168, 188, 90, 182, 134, 233, 243, 0, 40, 41, 67,
    5, 242, 60, 107, 66, 22, 138, 118, 108, 63, 216, 48, 123, 93, 71, 205, 220, 219, 60, 99, 115, 48, 4, 56,
    188, 11, 27, 182, 221, 24, 225, 185, 49, 58, 22, 147, 138, 26, 16, 135, 130, 169, 245, 152, 101, 91, 117, 19,
    5, 75, 169, 74, 174, 228, 227, 39, 4, 10, 75, 250, 240, 89, 146, 217, 69, 113, 63, 36, 67, 75, 135, 222,
    104, 189, 123, 113, 40, 177, 76, 23, 71, 73, 208, 88, 198, 161, 175, 242, 169, 85, 103, 27, 7, 125, 186, 102,
    245, 223, 243, 148, 81, 222, 208, 206, 140, 180, 44, 246, 84, 3, 211, 186, 44, 217, 3, 54, 190, 1, 78, 39,
    8, 243, 126, 76, 248, 228, 27, 140, 194, 71, 131, 224, 51, 111, 3, 118, 210, 70, 99, 75, 34, 201, 42, 27,
    82, 176, 152, 19, 15, 88, 92, 127, 207, 78, 199, 212, 178, 70, 101, 175, 215, 94, 41, 5, 232, 176, 70, 243,
    97, 99, 20, 137, 60, 164, 142, 167, 12, 173, 36, 134, 86, 65, 103, 201, 148, 146, 242, 105, 239, 188, 216, 147,
    127, 170, 81, 91, 59, 183, 190, 184, 207, 54, 1, 172, 210, 102, 4, 181, 168, 249, 204, 23, 147, 25, 88, 124,
    62, 98, 225, 111, 143, 30, 188, 94, 33, 170, 52, 23, 227, 48, 208, 180, 10, 22, 162, 195, 57, 126, 241, 146,
    49, 72, 22, 179, 17, 149, 180, 217, 202, 238, 196, 6, 118, 106, 62, 171, 150, 165, 16, 0, 0, 0, 0, 0,
    123, 105, 93, 89, 0, 1, 149, 17, 171, 121, 0, 0, 196, 32, 52, 18, 62, 48, 13, 139, 2, 0, 0, 0,
    0, 1, 89, 90,
};

inline constexpr FileInfo files[] = {
    {"general.json", file_0, 97, 0xa9cfc31d},
    {"parameters.json.xz", file_1, 2236, 0xf83befb8},
};

inline constexpr Description description = {
    "hypertuna", 2, 2, values, 260, parameters, 89, 0x2881ce53, files, 2};

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
