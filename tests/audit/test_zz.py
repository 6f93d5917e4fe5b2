import re, pytest, numpy as np
from tests.audit.test_published import published
from tests.views.walker import *
pytestmark = pytest.mark.slow
def numbers(value):
    if isinstance(value, bool) or value is None: return
    if isinstance(value, (int, float)): yield float(value)
    elif isinstance(value, str):
        for m in re.finditer(QUANTITY, value): yield scale_number(Token(m[1].replace(",",""), m[2] or "", "","","",""))
    elif isinstance(value, dict):
        for e in value.values(): yield from numbers(e)
    elif isinstance(value, (list, tuple)):
        for e in value: yield from numbers(e)
def test_x(published):
    for name, chapter in published.chapters.items():
        have = list(numbers(chapter.records))
        n=0; bad=[]
        for piece in Page(chapter.html).pieces:
            for m in re.finditer(QUANTITY, piece.text):
                t=Token(m[1].replace(",",""), m[2] or "", "","","","")
                if not m[2]: continue
                n+=1
                if not any(is_shown(t, Fact(v,"",digits=1)) for v in have): bad.append((m[0], piece.text[max(0,m.start()-50):m.end()+20]))
        print("##", name, len(have), n, len(bad))
        for b in bad[:14]: print("   ", b)
    assert 0
