#!/usr/bin/env python3
"""Builds parts of mosaics of 43,200 x 21,600 and 172,800 x 86,400 pixels over a real picture and real elevation, and holds the peak of
their resident memory to --memory, whatever the size.

    tests/build_memory_test.py PROGRAM PROJECT WORK_FOLDER
"""
import os
import pathlib
import shutil
import sys

MEMORY_MIB = 128  # the least that is taken


def mosaic(path, source, width, height, source_size, bands, kind):
    """One source scaled over the whole globe."""
    band = "".join(
        f'<VRTRasterBand dataType="{kind}" band="{b}"><ColorInterp>{colour}</ColorInterp><SimpleSource>'
        f'<SourceFilename relativeToVRT="1">{source}</SourceFilename><SourceBand>{b}</SourceBand>'
        f'<SrcRect xOff="0" yOff="0" xSize="{source_size[0]}" ySize="{source_size[1]}"/>'
        f'<DstRect xOff="0" yOff="0" xSize="{width}" ySize="{height}"/></SimpleSource></VRTRasterBand>'
        for b, colour in enumerate(bands, 1))
    path.write_text(f'<VRTDataset rasterXSize="{width}" rasterYSize="{height}"><SRS>EPSG:4326</SRS>'
                    f'<GeoTransform>-180,{360 / width!r},0,90,0,{-180 / height!r}</GeoTransform>{band}</VRTDataset>')


def peak_mib(command):
    process = os.spawnv(os.P_NOWAIT, command[0], command)
    _, status, usage = os.wait4(process, 0)
    if status != 0:
        sys.exit(f"failed: {' '.join(command)}")
    return usage.ru_maxrss / 1024


def main():
    program, project, folder = sys.argv[1], pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(sys.argv[3]).resolve()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, link in (("bluemarble_dec2004_5400x2700.jpg", "picture.jpg"), ("etopo5_dem_10min.tif", "heights.tif")):
        os.symlink(project / "data" / "earth" / name, folder / link)
    failed = False
    for width in (43200, 172800):
        mosaic(folder / f"picture{width}.vrt", "picture.jpg", width, width // 2, (5400, 2700), ("Red", "Green", "Blue"), "Byte")
        mosaic(folder / f"heights{width}.vrt", "heights.tif", width, width // 2, (2160, 1080), ("Gray",), "Int16")
        pixel = 360 / width
        # The same number of pixels of each: 2,000 x 1,500, across a border of roots and of a cap.
        region = f"{43 - 1000 * pixel},{45 - 750 * pixel},{43 + 1000 * pixel},{45 + 750 * pixel}"
        for kind, source, more in (("imagery", f"picture{width}.vrt", []), ("elevation", f"heights{width}.vrt", []),
                                   ("imagery", f"picture{width}.vrt", ["--format", "png"])):
            output = folder / "out.tdb"
            output.unlink(missing_ok=True)
            peak = peak_mib([program, "build", str(output), str(folder / source), "--kind", kind, "--tiling", "geographic", "--region",
                             region, "--memory", str(MEMORY_MIB), "--jobs", "2"] + more)
            print(f"{source} {' '.join(more)}: {peak:.0f} MiB, {output.stat().st_size} bytes")
            failed = failed or peak > MEMORY_MIB
    sys.exit("more memory than was given" if failed else 0)


if __name__ == "__main__":
    main()
