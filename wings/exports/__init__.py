"""Exports: recordings as point files, pictures, tables and the data sets KITTI and nuScenes."""
