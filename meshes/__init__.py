"""Line meshes of bladed disks, ring meshes of casings, and mesh files."""
