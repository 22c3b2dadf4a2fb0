// Constants of the shading, written in what GLSL and C++ have in common: the tests' reference reads this same file.

// Sines of the sun's height. Sunlight fades in from below to above the horizon, as the sun is a disc in an atmosphere.
const float kSunriseBegins = -0.05f;
const float kSunriseEnds = 0.05f;

// Night lights are at full strength below the first and gone above the second.
const float kNightLightsFull = -0.12f;
const float kNightLightsOut = 0.02f;

// Linear light of a night-lights texel of full strength.
const float kNightLightRed = 1.0f;
const float kNightLightGreen = 0.78f;
const float kNightLightBlue = 0.45f;

// And a mirror of it shows the disc alone: the sine of its radius.
const float kSunRim = 0.005f;

// Water: the mean square of the slopes of its surface (Cox and Munk 1954, for a wind of 5 m/s: 0.003 + 0.00512 * 5), the
// share of light that it mirrors straight up, and the sine of the height of the eye below which it is taken for that.
const float kWaterSlopes = 0.0286f;
const float kWaterReflects = 0.02f;
const float kWaterGrazing = 0.05f;

// Middle grey, about which contrast turns: linear light of half of full sRGB.
const float kMiddleGrey = 0.2140411f;

// Arrays of pictures and of reliefs that one draw call may read: with the records of pictures 16 samplers, which is what
// every OpenGL has.
const int kMostBlocks = 12;
const int kMostReliefBlocks = 3;
const int kPlacesABlock = 65536;

// Blend modes.
const int kNormal = 0;
const int kMultiply = 1;
const int kScreen = 2;
const int kAdd = 3;
const int kOverlay = 4;

// Of pictures with air: by how many steps of 8 bits the noise moves light, from one end to the other.
const float kDither = 0.9f;

// Of pictures with air: light up to the first is shown as it is, more ever less. And the sun's disc, as light.
const float kShoulderBegins = 0.6f;
const float kSunDisc = 20.0f;
