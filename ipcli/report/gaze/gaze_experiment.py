"""tmp"""
def page(arrays, provenance, *, widest=900):
    """tmp"""
    return "<html></html>"
