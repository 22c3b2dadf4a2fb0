// The air, and the air as one eye sees it, in what GLSL and C++ have in common: air_model.h reads this same file. Metres.
// Light is in units of the ground's: 1 is what white ground sends back that faces the sun outside of all air, so that the
// sun's illuminance is pi.

struct AirModel {
  vec4 gas;                // scattered a metre at height 0; w: 1 / scale height
  vec4 aerosolScattering;  // likewise
  vec4 aerosolExtinction;  // scattered and absorbed; w: the sun's angular radius
  vec4 aerosolForward;     // mean cosine of the scattering angle; w: 1 / reach of ozone
  vec4 ozone;              // absorbed a metre at its middle; w: the height of its middle
  vec4 sphere;             // radius at height 0, heights of the bottom and of the top
};

// Texels of the tables.
const int kTransmittanceWidth = 256;
const int kTransmittanceHeight = 64;
const int kGlowSide = 32;
const int kGroundLightWidth = 128;
const int kGroundLightHeight = 8;

// Ground above this share of the air is lit as at it.
const float kGroundLightReach = 0.3f;

const float kPi = 3.14159265f;

// The air as one eye sees it: a table of all directions and distances, made anew for each frame. Vectors and lengths are
// those of body axes scaled so that the ellipsoid is a sphere ("_air").
//
// A direction is an azimuth about the eye's up, counted from the sun's on either side, and an angle from the nadir,
// counted from the horizon's: the table's lower part is of rays that meet the air's bottom, the upper part of all others.
// Everything is made of differences that are small where they matter: from 100,000 km the air is a line.

struct AirView {
  vec4 scale;    // from body axes; w: metres from the centre to the eye
  vec4 up;       // unit vector from the centre to the eye; w: light is drawn this many times as bright
  vec4 side;     // unit vector across it, on the sun's side; w: how high the eye is, one of kEyeLow and so on
  vec4 toSun;    // unit vector; w: what a pixel spans, radians
  vec4 horizon;  // sine and cosine of the angle from the nadir to where the bottom ends; scales of the two halves
  vec4 top;      // sine and cosine of that to where the air ends, from above it; squares of distances from the centre:
                 // the eye's, of one above the air the top's, less the bottom's; the top's less the eye's
};

const float kEyeLow = 0.0f;
const float kEyeHigh = 1.0f;    // in thin air
const float kEyeOutside = 2.0f;  // above all air

const int kViewAzimuths = 40;
const int kViewBelow = 64;  // directions from the nadir to the horizon: the line between day and night lies among them
const int kViewAbove = 48;  // and from there upwards
const int kViewRows = kViewBelow + kViewAbove;
const int kViewDistances = 16;

// The dome of the sky: its bands end where the table has rows.
const int kSkyBands = kViewAbove;
const int kSkyColumns = 192;
