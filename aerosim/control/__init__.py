"""From estimates to commands of mount, shutter and forward-motion compensation."""
