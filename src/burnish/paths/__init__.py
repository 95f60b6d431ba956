"""Tool paths over a surface: patterns, their lines and spacing, and the strokes that they become."""
